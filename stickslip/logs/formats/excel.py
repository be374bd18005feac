"""Logs as sheets of Excel workbooks."""

import io
import zipfile
from typing import Any

TITLE = "Excel"
SUFFIXES = (".xlsx", ".xlsm")
BEGINS, CONTAINS = (b"PK\x03\x04",), b"xl/workbook.xml"
NEEDS = ("openpyxl", "excel")

MOST = 1 << 28  # bytes of a workbook when it is unpacked


def contents(data: bytes) -> str:
    """Return the sheet with most numbers as text, its fields apart by tabulators."""
    from openpyxl import load_workbook

    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if (size := sum(member.file_size for member in archive.infolist())) > MOST:
            raise ValueError(f"{size} bytes unpacked; at most {MOST} are read")
    sheets = load_workbook(io.BytesIO(data), read_only=True, data_only=True).worksheets
    tables = [[[_text(cell) for cell in row] for row in sheet.values] for sheet in sheets]
    texts = ["\n".join("\t".join(row) for row in table) for table in tables]
    return max(texts, key=lambda text: sum(map(str.isdigit, text)), default="")


def _text(cell: Any) -> str:
    if isinstance(cell, float):
        return repr(cell)
    text = "" if cell is None else cell.isoformat() if hasattr(cell, "isoformat") else str(cell)
    return " ".join(text.split())
