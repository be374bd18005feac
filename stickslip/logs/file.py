"""Any log's file as a table of columns."""

from __future__ import annotations

from pathlib import Path

from stickslip.errors import RecordingError
from stickslip.fmi.files import read_limited
from stickslip.logs.matlab import read_matlab
from stickslip.logs.parquet import read_parquet
from stickslip.logs.table import LogTable
from stickslip.logs.text import read_text

MOST = 1 << 30
"""Bytes of a log; of one as text see ``text``."""
_MATLAB = (b"MATLAB ", b"\x89HDF")
_ARCHIVE = b"PK\x03\x04"


def read_table(path: Path, delimiter: str | None = None, decimal: str | None = None) -> LogTable:
    """Read a log: Parquet and MAT by what they begin with or are called, else text.

    Raises
    ------
    RecordingError
        When the file cannot be read as what it seems to be.
    """
    try:
        data = read_limited(path, MOST)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from None
    name, suffix = str(path), path.suffix.lower()
    if not data:
        raise RecordingError(f"{name}: empty; expected columns of numbers")
    if data.startswith(b"PAR1") or suffix in (".parquet", ".pq"):
        return read_parquet(name, data)
    if data.startswith(_MATLAB) or suffix == ".mat":
        return read_matlab(name, data)
    if data.startswith(_ARCHIVE):
        raise RecordingError(f"{name}: an archive or a spreadsheet; export the log as CSV")
    return read_text(name, data, delimiter, decimal)
