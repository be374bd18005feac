"""Formats of logs besides text: one module each, found in this folder.

A module has ``TITLE``, the format's name; ``SUFFIXES`` of its files; ``BEGINS``, with one of which
a file of the format begins; ``CONTAINS``, what it also has somewhere, if others begin so, too;
``NEEDS``, module and extra of the library that it takes, if that is optional; and one of

- ``contents(data: bytes)``, which returns signals as a tree of mappings, lists and arrays, or a
  table as text. It runs in a process of its own with limits of memory and time. The module is
  loaded there by its path, and imports no other module of the project.
- ``signals(data: bytes) -> list[Signal]``, which runs in our process, for readers that no content
  can crash. It raises ValueError.
"""

import gzip
import io
import zlib
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from stickslip.errors import RecordingError
from stickslip.fmi.additions import modules_of
from stickslip.fmi.files import read_limited
from stickslip.fmi.messages import installing
from stickslip.logs.recording import Finding
from stickslip.logs.signals import read_isolated, table_of
from stickslip.logs.table import LogTable
from stickslip.logs.text import MOST_BYTES, is_text, read_text

MOST = 1 << 30  # bytes of a log; of one as text see ``text``
_GZIP, _PART = b"\x1f\x8b", 1 << 20  # begin of a compressed file; bytes decompressed at a time
_FOREIGN = {
    b"PK\x03\x04": "an archive",
    b"\xd0\xcf\x11\xe0": "a workbook of Excel 97; save it as .xlsx",
    b"%PDF": "a PDF document",
}
_FORMATS = modules_of(__name__, "TITLE", "SUFFIXES", "BEGINS")
SUFFIXES = tuple(suffix for each in _FORMATS for suffix in each.SUFFIXES)


def read_table(path: Path, delimiter: str | None = None, decimal: str | None = None) -> LogTable:
    """Read a log of one of the formats, else text; raise RecordingError where that fails."""
    try:
        data = read_limited(path, MOST)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from None
    name, suffix = str(path), path.suffix.lower()
    if data.startswith(_GZIP):
        data, suffix = _decompressed(name, data), Path(path.stem).suffix.lower()
    if not data:
        raise RecordingError(f"{name}: empty; expected columns of numbers")
    begun = (each for each in _FORMATS if data.startswith(each.BEGINS))
    known = [each for each in begun if getattr(each, "CONTAINS", b"") in data]
    named = [each for each in _FORMATS if suffix in each.SUFFIXES]
    if not known and named and is_text(data):
        what = f"a text, not a file of {named[-1].TITLE} as its name says; rename it to .csv"
        raise RecordingError(f"{name}: {what}")
    if found := known or named:
        table = _read(found[-1], name, data, delimiter, decimal=decimal)  # old MAT has no mark
        if suffix and found[-1] not in named:
            what = f"the file is {found[-1].TITLE}, although its name ends in {suffix}"
            table = replace(table, findings=(Finding("note", what), *table.findings))
        return table
    for start, what in _FOREIGN.items():
        if data.startswith(start):
            raise RecordingError(f"{name}: {what}; expected a log, export it as CSV")
    return read_text(name, data, delimiter, decimal)


def _decompressed(name: str, data: bytes) -> bytes:
    """Return what a file of gzip holds, of which no more is taken than of a log as text."""
    parts, left = [], MOST_BYTES
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
            while part := file.read(_PART):
                parts.append(part)
                left -= len(part)
                if left < 0:
                    what = f"more than {MOST_BYTES} bytes when decompressed"
                    raise RecordingError(f"{name}: {what}; log fewer samples or columns")
    except (EOFError, OSError, zlib.error) as error:
        raise RecordingError(f"{name}: not a gzip file, or damaged ({error})") from None
    return b"".join(parts)


def _read(
    module: ModuleType, path: str, data: bytes, delimiter: str | None, decimal: str | None
) -> LogTable:
    """Read a file of a format."""
    library, extra = getattr(module, "NEEDS", ("numpy", ""))
    if find_spec(library) is None:
        needed = f"reading {module.TITLE} needs {library}"
        raise RecordingError(f"{path}: {needed}; {installing(extra)}")
    if not hasattr(module, "signals"):
        found = read_isolated(path, data, str(module.__file__), module.TITLE)
    else:
        try:
            found = module.signals(data)
        except ValueError as error:
            what = f"not a {module.TITLE} file, or damaged ({error})"
            raise RecordingError(f"{path}: {what}") from None
    if isinstance(found, str):
        return read_text(path, found.encode(), delimiter or "\t", decimal)
    return table_of(path, found)
