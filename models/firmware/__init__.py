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
from stickslip.models.firmware.program import is_reserved
from stickslip.models.firmware.structured_text import st_file

Language = Literal["c", "st"]
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
    """Write a compensator as ``NAME.c`` and ``NAME.h``, or as ``NAME.st``.

    Parameters
    ----------
    folder : is made if it is absent
    language : C99, in 64-bit or 32-bit floating point, or structured text of IEC 61131-3
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
    if language not in get_args(Language):
        raise ModelError(f"language is {language!r}; expected 'c' or 'st'")
    found = load_model(model, law).with_start(start or {})
    found = replace(found, name=checked_name(called or found.name))
    if language == "st" and is_reserved(struct_name(found)):
        raise ModelError(f"{found.name!r} is a word of structured text; choose another name")
    files = c_files(found) if language == "c" else st_file(found)
    if rotary:
        files = {name: _COMMENT.sub(_of_rotary, text) for name, text in files.items()}
    lines = [*map(_harmless, notes), *_memory(found)]
    begin, mark, end = ("/*", " * ", " */") if language == "c" else ("(*", "   ", "*)")
    head = "\n".join([begin, *(f"{mark}{line}" for line in lines), end, ""])
    headed = tuple(f"{found.name}{suffix}" for suffix in (".h", ".st"))
    files = {name: head + text if name in headed else text for name, text in files.items()}
    return [atomic_write(Path(folder) / name, text) for name, text in files.items()]


def _harmless(line: str) -> str:
    """Return a line that cannot end the comment in which it stands."""
    return re.sub(r"\*(?=[/)])|(?<=[/(])\*", "x", printable(line))


def _memory(model: Model) -> list[str]:
    """Return what a call of the code takes in 64-bit floating point."""
    roles: tuple[Role, ...] = ("state", "memory", "parameter")
    state, memory, parameters = (
        8 * sum(prod(size) for _, size in model.fields.get(role, ())) for role in roles
    )
    return [
        f"Memory: {state + memory} bytes of state and {parameters} bytes of parameters in 64 bits."
    ]


def _of_rotary(comment: re.Match[str]) -> str:
    """Return a comment with the units of a rotary drive in brackets."""
    return re.sub(r"\[.*?\]", lambda unit: motion_unit(unit[0], rotary=True), comment[0])
