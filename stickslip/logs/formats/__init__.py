"""Formats of logs besides text: one module each, found in this folder.

A module has ``recognises(data: bytes, suffix: str) -> bool``, which detects the format from the
content of a file or from the end of its name (``.mat``), and
``read(path: str, data: bytes) -> LogTable``, which raises RecordingError.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from stickslip.errors import RecordingError
from stickslip.fmi.files import read_limited
from stickslip.logs.table import LogTable
from stickslip.logs.text import read_text

MOST = 1 << 30
"""Bytes of a log; of one as text see ``text``."""
_ARCHIVE = b"PK\x03\x04"
_FORMATS = [import_module(f"{__name__}.{each.name}") for each in iter_modules(__path__)]


def read_table(path: Path, delimiter: str | None = None, decimal: str | None = None) -> LogTable:
    """Read a log of one of the formats, else text.

    Raises
    ------
    RecordingError
        When the file cannot be read as the format that content or name indicate.
    """
    try:
        data = read_limited(path, MOST)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from None
    name, suffix = str(path), path.suffix.lower()
    if not data:
        raise RecordingError(f"{name}: empty; expected columns of numbers")
    for ending in ("", suffix):  # the content decides before the name does
        for each in _FORMATS:
            if each.recognises(data, ending):
                table: LogTable = each.read(name, data)
                return table
    if data.startswith(_ARCHIVE):
        raise RecordingError(f"{name}: an archive or a spreadsheet; export the log as CSV")
    return read_text(name, data, delimiter, decimal)
