"""A log, read, cut where it is long, and checked."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from stickslip.logs.checks import check_recording
from stickslip.logs.description import Description
from stickslip.logs.joined import join
from stickslip.logs.plausibility import check_units
from stickslip.logs.reading import Reading, read_recording
from stickslip.logs.recording import Finding, Recording
from stickslip.servo.measurement import Array
from stickslip.thresholds import log_content

ROW = 0.02  # time over which the motion is averaged [s]
SPEEDS = np.geomspace(1e-4, 1.0, 13)  # limits of classes of speed, as shares of the top speed
STRONG = 0.5  # share of the strongest acceleration above which one shows the mass
PLACES = 8  # classes of the position
STRETCHES = 10  # of a long log, as long together as a recording may be (decision 184)
SLOW = 0.03  # speed at which they begin, over the top speed
GRID = 4  # places in a stretch where another may begin


def shortened(
    recording: Recording, share: float = 1.0, number: int = STRETCHES
) -> tuple[Recording, tuple[Finding, ...]]:
    """Return the stretches of a long recording that show most, and a note; a short one as it is.

    Such that follow each other are one. Of a share of what may be used there are fewer.
    """
    n, T_s = len(recording.t), recording.T_s
    most = round(share * max(log_content.LONGEST / T_s, log_content.MOST))
    motion = recording.velocity if recording.position is None else recording.position
    if n <= most or motion is None:
        return recording, ()
    rows, number = max(round(ROW / T_s), 1), max(round(share * number), 1)
    length = most // number // rows
    motion = motion[: n // rows * rows].reshape(-1, rows).mean(axis=1)
    begins = _most_telling(motion, length, number, is_position=recording.position is not None)
    ends = begins + length
    limits = np.setdiff1d(begins, ends) * rows, np.setdiff1d(ends, begins) * rows
    parts = list(zip(*(one.tolist() for one in limits), strict=True))
    places = ", ".join(f"{begin * T_s:.4g} to {end * T_s:.4g} s" for begin, end in parts)
    note = Finding("note", "of the log what shows most is used", f"{places}, of {n * T_s:.4g} s")
    cut = [recording.part(*one) for one in parts]
    if len(cut) == 1:
        return cut[0], (note,)
    joined = join(cut, [None] * len(cut), [0.0] * len(cut))
    segments = tuple(replace(one, log=0) for one in joined.segments)
    return replace(joined, source=recording.source, segments=segments), (note,)


def _most_telling(
    motion: Array, length: int, number: int, *, is_position: bool
) -> NDArray[np.intp]:
    """Return where stretches begin that together have rows of most kinds.

    Kinds are classes of speed and of position, strong accelerations and reversals, each by
    direction. What a further row of a kind adds falls with their number, as the logarithm of that
    does. One stretch after the other is chosen. Each but one at the begin of the log begins where
    the drive slides slowly, or else moves fastest, near there: friction then does not depend on
    what was before, and the controller's low-pass has little to remember.
    """
    v, x = (np.gradient(motion), motion) if is_position else (motion, np.cumsum(motion))
    a, top = np.gradient(v), max(float(np.quantile(np.abs(v), 0.999)), 1e-300)
    speed = np.digitize(np.abs(v) / top, SPEEDS)
    place = np.digitize(x, np.linspace(np.min(x), np.max(x), PLACES + 1)[1:-1])
    moves = np.flatnonzero(speed > 0)
    turns = np.zeros(len(v), dtype=bool)
    turns[moves[1:][np.diff(np.sign(v[moves])) != 0]] = True
    kinds = [speed == k for k in range(1, len(SPEEDS) + 1)]
    kinds += [(place == k) & (speed > 0) for k in range(PLACES)]
    kinds += [np.abs(a) > STRONG * np.quantile(np.abs(a), 0.999), turns]
    apart = max(length // GRID, 1)
    begins = np.arange(0, len(v) - length - apart + 2, apart)
    off = np.abs(np.log(np.maximum(np.abs(v) / top, 1e-9) / SLOW))
    begins[1:] += np.argmin(sliding_window_view(off, apart)[begins[1:]], axis=1)
    counts = (
        np.append(0, np.cumsum(kind & (np.sign(v) == way))) for kind in kinds for way in (1.0, -1.0)
    )
    rows = np.array([count[begins + length] - count[begins] for count in counts])
    chosen: list[int] = []
    total = np.zeros(len(rows))
    while len(chosen) < number and len(begins):
        best = int(np.argmax(np.log1p(total[:, np.newaxis] + rows).sum(axis=0)))
        chosen.append(int(begins[best]))
        total += rows[:, best]
        left = np.abs(begins - begins[best]) >= length
        begins, rows = begins[left], rows[:, left]
    return np.sort(chosen)


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
    reading, findings = read_stretches(path, description, number=1)
    reading = replace(reading, recording=known(reading.recording))
    return reading, with_checks(reading, findings)


def read_stretches(
    path: Path, description: Description, share: float = 1.0, number: int = STRETCHES
) -> tuple[Reading, tuple[Finding, ...]]:
    """Read a log; return what of it shows most, a share of the longest, and findings."""
    reading = read_recording(path, description, strict=False)
    recording, cut = shortened(reading.recording, share, number)
    return replace(reading, recording=recording), (*reading.findings, *cut)


def with_checks(
    reading: Reading, findings: tuple[Finding, ...], *, alone: bool = True
) -> tuple[Finding, ...]:
    """Return the findings of reading and checking a log; of several, none about the drive."""
    checks = check_recording(
        reading.recording, reading.controller, reading.force_limit, alone=alone
    )
    return (*findings, *check_units(reading), *checks)
