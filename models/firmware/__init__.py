"""A compensator as source code: C for a drive's firmware, structured text for a PLC."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Literal, get_args

from stickslip.fmi.files import atomic_write
from stickslip.fmi.messages import printable
from stickslip.models.errors import ModelError
from stickslip.models.export.description import Model, Role
from stickslip.models.export.package import checked_name, load_model
from stickslip.models.export.units import motion_unit
from stickslip.models.firmware.c99 import c_files, struct_name
from stickslip.models.firmware.combined import ADDED_FORCE, combined_c, combined_st
from stickslip.models.firmware.plcopen import plcopen_text
from stickslip.models.firmware.program import is_reserved
from stickslip.models.firmware.structured_text import st_text

Language = Literal["c", "st", "plcopen"]
_COMMENT = re.compile(r"(?:/\*|\(\*).*?(?:\*/|\*\))", re.DOTALL)


def write_compensator(
    folder: Path | str,
    language: Language,
    *,
    start: Mapping[str, float] | None = None,
    law: str | None = None,
    model: str = "compensator",
    called: str | None = None,
    rotary: bool = False,
    notes: Sequence[str] = (),
) -> list[Path]:
    """Write a compensator as ``NAME.c`` and ``NAME.h``, as ``NAME.st`` or as ``NAME.xml``.

    Parameters
    ----------
    folder : is made if it is absent
    language : C99, in 64-bit or 32-bit floating point, or structured text of IEC 61131-3, as text
        or as XML of PLCopen, TC6 2.01
    start : parameter -> start value, in the unit of model.toml, instead of the one there
    law : friction law of a feedforward, by default LuGre
    model : name of the compensator's model
    called : name in the code, by default that of the model
    rotary : with the units of a rotary drive
    notes : lines for the head of the code, such as where its numbers come from

    Raises
    ------
    ModelError
        When it cannot have the name, or there is no such language.
    UnknownModel
        When there is no such model, or it is not available in structured text.
    StartValueError, OSError
    """
    found = load_model(model, law).with_start(start or {})
    found = replace(found, name=checked_name(called or found.name))
    if language != "c" and is_reserved(struct_name(found)):
        raise ModelError(f"{found.name!r} is a word of structured text; choose another name")
    return _write(folder, language, [found], found.name, rotary=rotary, notes=notes)


def write_combined(
    folder: Path | str,
    language: Language,
    blocks: Sequence[Model],
    *,
    rotary: bool = False,
    notes: Sequence[str] = (),
) -> list[Path]:
    """Write blocks of a drive behind one call, ``added_force``; see ``write_compensator``.

    Each of the blocks, with their start values, takes the force of the one before it. C has files
    of each block beside ``added_force.c`` and ``.h``, the other languages one file. Raises
    UnknownModel also when a block has an input that is not of a drive.
    """
    return _write(folder, language, blocks, ADDED_FORCE, rotary=rotary, notes=notes)


def _write(
    folder: Path | str,
    language: Language,
    blocks: Sequence[Model],
    name: str,
    *,
    rotary: bool,
    notes: Sequence[str],
) -> list[Path]:
    if language not in get_args(Language):
        known = ", ".join(map(repr, get_args(Language)))
        raise ModelError(f"language is {language!r}; expected {known}")
    is_c, is_combined = language == "c", name == ADDED_FORCE
    files: dict[str, str] = {}
    if is_c:
        for block in blocks:
            files |= c_files(block)
        files |= combined_c(blocks) if is_combined else {}
    else:
        texts = [*map(st_text, blocks), *([combined_st(blocks)] if is_combined else [])]
        files[f"{name}.st"] = "\n".join(texts)
    if rotary:
        files = {file: _COMMENT.sub(_of_rotary, text) for file, text in files.items()}
    # Notes that cannot end the comment in which they stand
    harmless = (re.sub(r"\*(?=[/)])|(?<=[/(])\*", "x", printable(line)) for line in notes)
    lines = [*harmless, _memory(blocks)]
    begin, mark, end = ("/*", " * ", " */") if is_c else ("(*", "   ", "*)")
    head = "\n".join([begin, *(f"{mark}{line}" for line in lines), end, ""])
    headed = f"{name}{'.h' if is_c else '.st'}"
    files[headed] = head + files[headed]
    if language == "plcopen":
        files = {f"{name}.xml": plcopen_text(name, files[headed])}
    return [atomic_write(Path(folder) / file, text) for file, text in files.items()]


def _memory(blocks: Sequence[Model]) -> str:
    """Return what a call of the code takes in 64-bit floating point."""
    roles: tuple[Role, ...] = ("state", "memory", "parameter")
    state, memory, parameters = (
        8 * sum(prod(size) for block in blocks for _, size in block.fields.get(role, ()))
        for role in roles
    )
    state += memory
    return f"Memory: {state} bytes of state and {parameters} bytes of parameters in 64 bits."


def _of_rotary(comment: re.Match[str]) -> str:
    """Return a comment with the units of a rotary drive in brackets, and its words."""
    text = comment[0].replace("Moving mass", "Moment of inertia").replace("the stage", "the axis")
    return re.sub(r"\[.*?\]", lambda unit: motion_unit(unit[0], rotary=True), text)
