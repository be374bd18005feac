"""The table of a fleet: a CSV with a row for each drive."""

from __future__ import annotations

import csv
import io
import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from stickslip import models
from stickslip.commands.assignments import drive_changes
from stickslip.errors import UsageError
from stickslip.fleet.drive import Drive, LogSource, Variant
from stickslip.fmi.files import MOST_TEXT, read_limited
from stickslip.fmi.messages import suggestion
from stickslip.pipeline.reproduction import drive_truth

COLUMNS = ("name", "log", "config", "set")
_NAME = re.compile(r"\w[\w.-]{0,79}")


def read_fleet(path: Path) -> list[Drive]:
    """Read the table: ``name``, and either ``log`` (with ``config``) or ``set``.

    Paths are relative to the table. Whether logs and configurations can be read is a matter of
    each drive, not of the table.

    Raises
    ------
    UsageError
        When it cannot be read; names row and column, counted as a spreadsheet does.
    """
    header, *rows = _rows(path)
    names = [cell.strip() for cell in header]
    for name in names:
        if name not in COLUMNS:
            expected = f"expected {', '.join(COLUMNS)}, got '{name}'{suggestion(name, COLUMNS)}"
            raise UsageError(f"{path}: row 1: {expected}")
        if names.count(name) > 1:
            raise UsageError(f"{path}: column '{name}' is there twice")
    if "name" not in names or not {"log", "set"} & set(names):
        got = ", ".join(names)
        raise UsageError(f"{path}: expected columns name and log, or name and set, got {got}")
    drives: dict[str, Drive] = {}
    for number, cells in enumerate(rows, start=2):
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(names):
            raise UsageError(f"{path}: row {number}: expected {len(names)} cells, got {len(cells)}")
        row = {name: cell.strip() for name, cell in zip(names, cells, strict=True)}
        drive = _Row(path, number, row).drive()
        if drive.name.casefold() in drives:
            raise UsageError(
                f"{path}: row {number}, column name: '{drive.name}' is there already; expected a "
                "name for each drive, upper and lower case alike"
            )
        drives[drive.name.casefold()] = drive
    if not drives:
        raise UsageError(f"{path}: expected a row for each drive, got none")
    return list(drives.values())


def _rows(path: Path) -> Sequence[list[str]]:
    try:
        text = read_limited(path, MOST_TEXT).decode("utf-8-sig")
        rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path}: not a CSV file in UTF-8 ({error})") from None
    if not rows or not any(rows[0]):
        raise UsageError(f"{path}: expected columns {', '.join(COLUMNS)} in the first row")
    return rows


class _Row:
    """A row on its way to a drive."""

    def __init__(self, path: Path, number: int, cells: dict[str, str]) -> None:
        self.path, self.number, self.cells = path, number, cells

    def drive(self) -> Drive:
        name, log, config, changes = (self.cells.get(column, "") for column in COLUMNS)
        if not _NAME.fullmatch(name):
            self._refuse("name", "expected letters, digits, '_', '-' and '.'", name)
        if bool(log) == bool(changes):
            both = f"{log} and {changes}" if log else ""
            self._refuse("log", "expected either a log or, in column set, a variant", both)
        if config and not log:
            self._refuse("config", "expected nothing, because there is no log", config)
        row = {column: cell for column, cell in self.cells.items() if cell}
        if changes:
            return Drive(name, Variant(self._changes(changes)), row)
        folder = self.path.parent
        return Drive(name, LogSource(folder / log, folder / config if config else None), row)

    def _changes(self, text: str) -> dict[str, float | str]:
        try:
            changes = drive_changes(shlex.split(text))
            drive_truth(changes)
        except (ValueError, models.ModelError) as error:  # a UsageError is a ValueError
            reason = str(error).removeprefix("--set ")
            raise UsageError(f"{self.path}: row {self.number}, column set: {reason}") from None
        return changes

    def _refuse(self, column: str, expected: str, got: str) -> NoReturn:
        got = f"'{got}'" if got else "nothing"
        raise UsageError(f"{self.path}: row {self.number}, column {column}: {expected}, got {got}")
