"""What ``stickslip learn --check`` does with a log: read it, and say what it shows."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from stickslip.identification.sliding.position_force import with_position_force
from stickslip.logs import Description, Finding, Reading, read_and_check
from stickslip.logs.formats import read_table


class CheckedLog(NamedTuple):
    """A log that was read, and what was found."""

    reading: Reading
    findings: tuple[Finding, ...]

    def __repr__(self) -> str:
        return "\n".join(map(str, (self.reading.recording.source, *self.findings)))


def check_log(path: Path | str, description: Description | None = None) -> CheckedLog:
    """Read a log and check it, without learning from it.

    Parameters
    ----------
    path : of the log
    description : of its columns and of the controller; what it leaves open is detected

    Returns
    -------
    ``reading``, the stretch of the log that is used, in SI units, with the columns in their roles,
    and ``findings``, errors included; as text, a line for each finding

    Raises
    ------
    RecordingError, UsageError
        When the log cannot be read, or lacks a signal.
    """
    reading, findings = read_and_check(
        Path(path), description or Description(), known=with_position_force
    )
    if any(one.severity == "error" for one in findings):
        return CheckedLog(reading, findings)
    from stickslip.studies.learn.controller_findings import check_description  # late: runs FMUs

    return CheckedLog(reading, check_description(reading, findings))


def log_columns(path: Path | str, description: Description | None = None) -> dict[str, str]:
    """Return the unit that a log states for each of its columns, empty where it states none.

    Parameters
    ----------
    path : of the log
    description : whose delimiter and decimal sign count

    Raises
    ------
    RecordingError
        When the log cannot be read.
    """
    given = description or Description()
    table = read_table(Path(path), given.delimiter, given.decimal)
    return {name: table.units.get(name, "") for name in table.names}
