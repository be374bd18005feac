"""A log, read, cut where it is long, and checked."""

from dataclasses import replace
from pathlib import Path

from stickslip.logs.checks import check_recording
from stickslip.logs.description import Description
from stickslip.logs.plausibility import check_units
from stickslip.logs.reading import Reading, read_recording
from stickslip.logs.recording import Finding
from stickslip.logs.stretch import shortened


def read_and_check(path: Path, description: Description) -> tuple[Reading, tuple[Finding, ...]]:
    """Read a log and return the stretch of it that shows most, with findings, errors included.

    Raises RecordingError, UsageError when it cannot be read.
    """
    reading = read_recording(path, description, strict=False)
    recording, cut = shortened(reading.recording)
    reading = replace(reading, recording=recording)
    checks = check_recording(recording, reading.controller, reading.force_limit)
    return reading, (*reading.findings, *cut, *check_units(reading), *checks)
