"""The drives of a fleet, and the table that lists them: a CSV with a row for each."""

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from stickslip import models
from stickslip.commandline.assignments import drive_changes
from stickslip.errors import UsageError
from stickslip.logs.listing import read_listing
from stickslip.papers.lugre.reproduction import drive_truth
from stickslip.servo.systems import Changes

COLUMNS = ("name", "log", "config", "set")
SIMULATED = "simulated drive"
_NAME = re.compile(r"\w[\w.-]{0,79}")


@dataclass(frozen=True)
class LogSource:
    """A recording in a CSV, Parquet or MAT file, and the TOML file that describes it, if any."""

    log: Path
    config: Path | None = None


@dataclass(frozen=True)
class Drive:
    """A row of a fleet's table."""

    name: str  # unique, and valid as the name of a folder
    # of its recording: a log, or parameters of a simulated drive that differ from Table 2
    source: LogSource | Changes
    row: Mapping[str, str]  # its cells as they were written, by column

    @property
    def kind(self) -> str:
        """What was recorded: a simulated drive, or whatever made the log."""
        return "log" if isinstance(self.source, LogSource) else SIMULATED


def read_fleet(path: Path) -> list[Drive]:
    """Read the table: ``name``, and either ``log`` (with ``config``) or ``set``.

    Paths are relative to the table. Whether logs and configurations can be read is a matter of each
    drive, not of the table. Raises UsageError when it cannot be read; names row and column, counted
    as a spreadsheet does.
    """
    rows = read_listing(path, COLUMNS)
    names = rows[0][1] if rows else COLUMNS
    if "name" not in names or not {"log", "set"} & set(names):
        got = ", ".join(names)
        raise UsageError(f"{path}: expected columns name and log, or name and set, got {got}")
    drives: dict[str, Drive] = {}
    for number, row in rows:
        try:
            drive = _drive(path.parent, row)
        except ValueError as error:
            raise UsageError(f"{path}: row {number}, column {error}") from None
        if drive.name.casefold() in drives:
            raise UsageError(
                f"{path}: row {number}, column name: '{drive.name}' is there already; expected a "
                "name for each drive, upper and lower case alike"
            )
        drives[drive.name.casefold()] = drive
    if not drives:
        raise UsageError(f"{path}: expected a row for each drive, got none")
    return list(drives.values())


def _drive(folder: Path, cells: dict[str, str]) -> Drive:
    """Return the drive of a row; errors begin with the name of the column."""
    name, log, config, changes = (cells.get(column, "") for column in COLUMNS)
    if not _NAME.fullmatch(name):
        raise ValueError(f"name: expected letters, digits, '_', '-' and '.', got {_shown(name)}")
    if bool(log) == bool(changes):
        both = _shown(f"{log} and {changes}" if log else "")
        raise ValueError(f"log: expected either a log or, in column set, a variant, got {both}")
    if config and not log:
        raise ValueError(f"config: expected nothing, because there is no log, got '{config}'")
    row = {column: cell for column, cell in cells.items() if cell}
    if log:
        return Drive(name, LogSource(folder / log, folder / config if config else None), row)
    try:
        variant = drive_changes(shlex.split(changes))
        drive_truth(variant)
    except (ValueError, models.ModelError) as error:
        raise ValueError(f"set: {str(error).removeprefix('--set ')}") from None
    return Drive(name, variant, row)


def _shown(text: str) -> str:
    return f"'{text}'" if text else "nothing"
