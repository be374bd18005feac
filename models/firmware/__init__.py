"""The compensator as source code: C for a drive's firmware, structured text for a PLC."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from stickslip.fmi.files import atomic_write
from stickslip.models.export.package import load_model
from stickslip.models.firmware.c99 import c_files
from stickslip.models.firmware.structured_text import st_file

Language = Literal["c", "st"]


def write_compensator(
    folder: Path | str, language: Language, *, start: Mapping[str, float] | None = None
) -> list[Path]:
    """Write the compensator as ``compensator.c`` and ``.h``, or as ``compensator.st``.

    Parameters
    ----------
    folder : is made if it is absent
    language : C99, in 64-bit or 32-bit floating point, or structured text of IEC 61131-3
    start : parameter -> start value, in the unit of model.toml, instead of the one there

    Raises
    ------
    StartValueError
        When there is no such parameter, or the value is out of its range.
    OSError
        When a file cannot be written.
    """
    model = load_model("compensator").with_start(start or {})
    files = c_files(model) if language == "c" else st_file(model)
    return [atomic_write(Path(folder) / name, text) for name, text in files.items()]
