"""The drives of a fleet, and the table that lists them: a CSV with a row for each."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from stickslip.errors import UsageError
from stickslip.logs.listing import read_listing

COLUMNS = ("name", "log", "config")
_NAME = re.compile(r"\w[\w.-]{0,79}")


@dataclass(frozen=True)
class Drive:
    """A row of a fleet's table."""

    name: str  # unique, and valid as the name of a folder
    files: Mapping[str, Path]  # its log, and the TOML file that describes it, if any, by column
    row: Mapping[str, str]  # its cells as they were written, by column


def read_fleet(path: Path) -> list[Drive]:
    """Read the table: ``name``, ``log`` and, if needed, ``config``.

    Paths are relative to the table. Whether logs and configurations can be read is a matter of each
    drive, not of the table. Raises UsageError when it cannot be read; names row and column, counted
    as a spreadsheet does.
    """
    rows = read_listing(path, COLUMNS)
    names = rows[0][1] if rows else COLUMNS
    if not {"name", "log"} <= set(names):
        raise UsageError(f"{path}: expected columns name and log, got {', '.join(names)}")
    drives: dict[str, Drive] = {}
    for number, row in rows:
        name = row["name"]
        if not _NAME.fullmatch(name):
            got = f"'{name}'" if name else "nothing"
            fault = f"name: expected letters, digits, '_', '-' and '.', got {got}"
        elif name.casefold() in drives:
            fault = f"name: '{name}' is there already; expected a name for each drive, upper and"
            fault += " lower case alike"
        elif not row["log"]:
            fault = "log: expected the log of the drive, got nothing"
        else:
            cells = {column: cell for column, cell in row.items() if cell}
            files = {one: path.parent / cells[one] for one in COLUMNS[1:] if one in cells}
            drives[name.casefold()] = Drive(name, files, cells)
            continue
        raise UsageError(f"{path}: row {number}, column {fault}")
    if not drives:
        raise UsageError(f"{path}: expected a row for each drive, got none")
    return list(drives.values())
