"""A log, read and checked."""

from pathlib import Path

from stickslip.logs.checks import check_recording
from stickslip.logs.description import Description
from stickslip.logs.plausibility import check_units
from stickslip.logs.reading import Reading, read_recording
from stickslip.logs.recording import Finding


def read_and_check(path: Path, description: Description) -> tuple[Reading, tuple[Finding, ...]]:
    """Read a log and return it with its findings, errors included.

    Raises RecordingError, UsageError when it cannot be read.
    """
    reading = read_recording(path, description, strict=False)
    checks = check_recording(reading.recording, reading.controller, reading.force_limit)
    return reading, (*reading.findings, *check_units(reading), *checks)
