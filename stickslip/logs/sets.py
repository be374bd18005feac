"""Sets of logs of one drive: files, folders, and tables that say what differs from log to log."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from stickslip.errors import UsageError
from stickslip.logs.description import GAINS, Description, load_description
from stickslip.logs.formats import SUFFIXES
from stickslip.logs.listing import read_listing

TEXT = (".csv", ".txt", ".tsv", ".dat", ".log")
COLUMNS = ("log", "config", "load", "controller", "gains", "kind", "use")
"""Columns of a table: ``use`` is learn or validate, ``kind`` is for the reader."""


@dataclass(frozen=True)
class Log:
    """One log of a set."""

    path: Path
    description: Description
    load: float = 0.0  # mass that the drive moved beside its own [kg], or moment of inertia
    validates: bool = False  # whether it is predicted, not learned


def logs_of(paths: Sequence[Path], description: Description) -> list[Log]:
    """Return the logs of files, folders and tables.

    A folder stands for all logs in it, in the order of their names. A table is a CSV file whose
    first column is headed ``log``; its paths are relative to the table. What it does not say
    follows from the description.

    Raises UsageError when a folder has no log, or a table does not suit.
    """
    return [log for path in paths for log in _logs(path, description)]


def _logs(path: Path, description: Description) -> Iterator[Log]:
    table = path / "runs.csv" if path.is_dir() else path
    if _is_table(table):
        yield from _of_table(table, description)
    elif path.is_dir():
        known = {*TEXT, *SUFFIXES}
        suffix = {one: Path(one.name.lower().removesuffix(".gz")).suffix for one in path.iterdir()}
        found = sorted(one for one in suffix if suffix[one] in known)
        if not found:
            expected = ", ".join(sorted(known))
            raise UsageError(f"{path}: no log in this folder; expected files of {expected}")
        yield from (Log(one, description) for one in found)
    else:
        yield Log(path, description)


def _is_table(path: Path) -> bool:
    if not path.is_file():  # what it is, or that it is not there, is told where it is read
        return False
    try:
        with path.open("rb") as file:
            begin = file.read(64).removeprefix(b"\xef\xbb\xbf")
    except OSError:
        return False
    first = re.split(rb"[,;\t\r\n]", begin)[0]
    return first.strip().strip(b'"').lower() == b"log"


def _of_table(path: Path, description: Description) -> Iterator[Log]:
    rows = read_listing(path, COLUMNS)
    if not rows:
        raise UsageError(f"{path}: a table of logs without a row")
    for number, row in rows:
        yield _row(path, row, description, at=f"{path}: row {number}")


def _row(path: Path, row: dict[str, str], description: Description, *, at: str) -> Log:
    log = path.parent / row["log"]
    if not row["log"] or not log.is_file():
        raise UsageError(f"{at}: log '{row['log']}': no such file beside the table")
    own = load_description(path.parent / row["config"]) if row.get("config") else description
    if controller := row.get("controller"):
        own = replace(own, controller=controller, gains=_gains(row.get("gains", ""), at))  # type: ignore[arg-type]
    elif gains := row.get("gains"):
        own = replace(own, gains={**own.gains, **_gains(gains, at)})
    if (use := row.get("use") or "learn") not in ("learn", "validate"):
        raise UsageError(f"{at}: use '{use}': expected learn or validate")
    return Log(log, own, _load(row.get("load", ""), at), validates=use == "validate")


def _gains(text: str, at: str) -> dict[str, float]:
    found = {}
    for word in text.split():
        name, _, value = word.partition("=")
        if name not in GAINS or (number := _number(value)) is None:
            raise UsageError(
                f"{at}: gains '{word}': expected NAME=VALUE in SI units, with a name of "
                f"{', '.join(GAINS)}"
            )
        found[name] = number
    return found


def _load(text: str, at: str) -> float:
    load = _number(text or "0")
    if load is None:
        raise UsageError(
            f"{at}: load '{text}': expected a mass [kg] or moment of inertia [kg m^2] as a number"
        )
    return load


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
