"""A log, read, cut where it is long, and checked."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from stickslip.logs.checks import check_recording
from stickslip.logs.description import Description
from stickslip.logs.plausibility import check_units
from stickslip.logs.reading import Reading, read_recording
from stickslip.logs.recording import Finding, Recording
from stickslip.servo.measurement import Array
from stickslip.thresholds import log_content

ROW = 0.02  # time over which the motion is averaged [s]
SPEEDS = np.geomspace(1e-4, 1.0, 13)  # limits of classes of speed, as shares of the top speed
STRONG = 0.5  # share of the strongest acceleration above which one shows the mass
OFFSETS = 100  # stretches that are compared


def shortened(recording: Recording, share: float = 1.0) -> tuple[Recording, tuple[Finding, ...]]:
    """Return the stretch of a long recording that shows most, and a note; a short one as it is."""
    n, T_s = len(recording.t), recording.T_s
    most = round(share * max(log_content.LONGEST / T_s, log_content.MOST))
    motion = recording.velocity if recording.position is None else recording.position
    if n <= most or motion is None:
        return recording, ()
    rows = max(round(ROW / T_s), 1)
    motion = motion[: n // rows * rows].reshape(-1, rows).mean(axis=1)
    begin = rows * _most_telling(motion, most // rows, is_position=recording.position is not None)
    note = Finding(
        "note",
        "the stretch of the log that shows most is used",
        f"{most * T_s:.4g} s from {begin * T_s:.4g} s on, of {n * T_s:.4g} s",
    )
    return recording.part(begin, begin + most), (note,)


def _most_telling(motion: Array, length: int, *, is_position: bool) -> int:
    """Return where the stretch begins that has rows of most kinds.

    Kinds are classes of speed, strong accelerations and reversals, each by direction. What a
    further row of a kind adds falls with their number, as the logarithm of that does.
    """
    v = np.gradient(motion) if is_position else motion
    a, top = np.gradient(v), max(float(np.quantile(np.abs(v), 0.999)), 1e-300)
    speed = np.digitize(np.abs(v) / top, SPEEDS)
    strong = np.abs(a) > STRONG * np.quantile(np.abs(a), 0.999)
    moves = np.flatnonzero(speed > 0)
    turns = np.zeros(len(v), dtype=bool)
    turns[moves[1:][np.diff(np.sign(v[moves])) != 0]] = True
    kinds = [speed == k for k in range(1, len(SPEEDS) + 1)] + [strong, turns]
    begins = np.unique(np.linspace(0, len(v) - length, OFFSETS).astype(int))
    shown = np.zeros(len(begins))
    for kind in kinds:
        for way in (1.0, -1.0):
            count = np.append(0, np.cumsum(kind & (np.sign(v) == way)))
            shown += np.log1p(count[begins + length] - count[begins])
    return int(begins[np.argmax(shown)])


def read_and_check(
    path: Path,
    description: Description,
    *,
    known: Callable[[Recording], Recording] = lambda recording: recording,
) -> tuple[Reading, tuple[Finding, ...]]:
    """Read a log and return the stretch of it that shows most, with findings, errors included.

    ``known`` adds the force that neither mass nor friction takes, before the stretch is checked.

    Raises RecordingError, UsageError when it cannot be read.
    """
    reading, findings = read_stretch(path, description)
    reading = replace(reading, recording=known(reading.recording))
    return reading, with_checks(reading, findings)


def read_stretch(
    path: Path, description: Description, share: float = 1.0
) -> tuple[Reading, tuple[Finding, ...]]:
    """Read a log; return the stretch, a share of the longest, that shows most, and findings."""
    reading = read_recording(path, description, strict=False)
    recording, cut = shortened(reading.recording, share)
    return replace(reading, recording=recording), (*reading.findings, *cut)


def with_checks(
    reading: Reading, findings: tuple[Finding, ...], *, alone: bool = True
) -> tuple[Finding, ...]:
    """Return the findings of reading and checking a log; of several, none about the drive."""
    checks = check_recording(
        reading.recording, reading.controller, reading.force_limit, alone=alone
    )
    return (*findings, *check_units(reading), *checks)
