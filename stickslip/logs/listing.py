"""Tables of what is to be done, as CSV files with known columns: rows with their numbers."""

import csv
import io
from collections.abc import Collection
from pathlib import Path

from stickslip.errors import UsageError
from stickslip.fmi.files import MOST_TEXT, read_limited
from stickslip.fmi.messages import suggestion


def read_listing(path: Path, columns: Collection[str]) -> list[tuple[int, dict[str, str]]]:
    """Return the rows that are not empty, by column, with numbers as a spreadsheet counts them.

    Raises UsageError when the file cannot be read, has other columns, or a row of another length.
    """
    try:
        text = read_limited(path, MOST_TEXT).decode("utf-8-sig")
        header, *rows = list(csv.reader(io.StringIO(text, newline=""), strict=True)) or [[]]
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path}: not a CSV file in UTF-8 ({error})") from None
    expected = f"expected columns {', '.join(columns)} in the first row"
    if not any(header):
        raise UsageError(f"{path}: {expected}")
    names = [cell.strip() for cell in header]
    for name in names:
        if name not in columns:
            got = f"got '{name}'{suggestion(name, tuple(columns))}"
            raise UsageError(f"{path}: row 1: expected {', '.join(columns)}, {got}")
        if names.count(name) > 1:
            raise UsageError(f"{path}: column '{name}' is there twice")
    found = []
    for number, cells in enumerate(rows, start=2):
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(names):
            raise UsageError(f"{path}: row {number}: expected {len(names)} cells, got {len(cells)}")
        row = {name: cell.strip() for name, cell in zip(names, cells, strict=True)}
        found.append((number, row))
    return found
