"""Signals of a log that contradict each other by a factor of units."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from stickslip.logs.finding import Finding
from stickslip.logs.motion import kinematics
from stickslip.logs.reading import Reading
from stickslip.logs.unit_factors import EQUALS, described_ratio, near_factor
from stickslip.logs.units import QUANTITIES, Unit, quantity_key, sized_unit
from stickslip.servo.measurement import Array, smoothed

RATE = "d(position)/dt"
ALIKE, SAME = 0.8, 0.98
"""Correlation from which one signal is the other's image, and from which a factor below
``SMALL`` is one of units: a controller that follows badly may be off by as much."""
SMALL = 20.0
FOLLOWS = 2.0
"""Ratio up to which a signal follows its command."""
LATE, FILTERED = 0.1, 0.01
"""Share of the log by which a signal may be later than its command, and a velocity late."""
CUTOFF = 0.02
"""Of the low-pass before a comparison, in sampling frequencies because the time may be wrong."""
FASTER, SLOWER = 200.0, 20.0
"""How much faster or slower than its log a controller may run."""


def contradictions(reading: Reading) -> Iterator[Finding]:
    """Yield pairs of signals, and a controller, that contradict each other by their scale."""
    recording, units = reading.recording, reading.units
    motion = kinematics(recording, CUTOFF / recording.T_s)
    signals: dict[str, Array] = {
        role: smoothed(signal, recording.T_s, motion.cutoff)
        for role in units
        if role != "time" and (signal := getattr(recording, role)) is not None
    }
    if "position" in signals and reading.timed:
        signals[RATE] = motion.v
    speed = "velocity" if "velocity" in signals else RATE
    for a, b, most, late in (
        (RATE, "velocity", EQUALS, FILTERED),
        ("position", "position_command", FOLLOWS, LATE),
        (speed, "velocity_command", FOLLOWS, LATE),
        ("force", "force_command", FOLLOWS, LATE),
    ):
        if a in signals and b in signals and (image := _image(signals[a], signals[b], late)):
            yield from _contradiction(reading, a, b, image, most)
    if T_s := reading.controller.T_s:
        ratio = recording.T_s / T_s
        if not 1 / SLOWER <= ratio <= FASTER:
            what = "the log's time and the controller's T_s contradict each other"
            figure = f"{recording.T_s:.4g} s and {T_s:.4g} s, a factor of {described_ratio(ratio)}"
            advice = "--gain T_s is in s; a unit of the log's time is set by --unit time=ms"
            yield Finding("error", what, figure, advice)


def _image(a: Array, b: Array, late: float) -> tuple[float, float] | None:
    """Return how many times larger b (n,) is than a (n,), and their correlation; None if unlike.

    The ratio is negative where one is inverted.

    The ratio of standard deviations is that of regression both ways, and needs no alignment; the
    correlation, at the best lag, tells whether one is the other's image. The farthest thousandths
    of the samples are cut off.
    """
    a, b = (np.clip(s, *np.quantile(s, (0.001, 0.999))) for s in (a, b))
    a, b = a - a.mean(), b - b.mean()
    sizes = float(np.std(a)), float(np.std(b))
    if min(sizes) == 0:
        return None
    lags = scipy.signal.correlate(b / sizes[1], a / sizes[0], mode="full", method="fft") / len(a)
    reach = int(late * len(a))
    lags = lags[len(a) - 1 - reach : len(a) + reach]
    if lags.max() >= ALIKE:
        return sizes[1] / sizes[0], float(lags.max())
    if lags.min() <= -SAME and lags.max() < ALIKE / 2:
        return -sizes[1] / sizes[0], -float(lags.min())
    return None


def _contradiction(
    reading: Reading, a: str, b: str, image: tuple[float, float], most: float
) -> Iterator[Finding]:
    """Yield the findings of two signals if b, an image of a, is not as large."""
    ratio, likeness = image
    what = f"{a} and {b} contradict each other"
    leave = f"--column {b}=none leaves {b} out"
    if ratio < 0:
        figure = f"they have opposite signs, {b} is {ratio:.4g} times {a}"
        yield Finding("error", what, figure, f"give {_scaled(reading, b, -1)}; {leave}")
    figure = f"{b} is {abs(ratio):.4g} times {a}"
    factor, name = near_factor(abs(ratio)) or (0.0, "")
    if factor and (likeness > SAME or not 1 / SMALL < factor < SMALL):
        ends = {b: 1 / factor, a: factor}
        if a == RATE:
            ends = {b: 1 / factor, "position": factor, "time": 1 / factor}
        advice = _corrections(reading, ends)
        yield Finding("error", what, f"{figure}, near {name}", f"{advice}; {leave}")
    elif not 1 / most <= abs(ratio) <= most:
        advice = f"a gear or the pitch of a screw is set by {_scaled(reading, b, 1 / abs(ratio))}"
        what = f"{a} and {b} differ in scale"
        yield Finding("warning", what, figure, f"{advice}; {leave}", spoils="values")


def _corrections(reading: Reading, ends: dict[str, float]) -> str:
    """Return options that multiply one of several signals, by role, by its factor."""
    units = reading.units
    options = []
    known = [role for role in ends if role in units]
    for role in sorted(known, key=lambda role: units[role] is not None):  # unstated ones first
        if reading.description.column(role).scale is not None:
            options.append(_scaled(reading, role, ends[role]))
        elif unit := _unit_for(reading, role, ends[role]):
            options.append(f"--unit {role}={unit.name}")
    if not options:
        names = " ".join(f"{role}=UNIT" for role in known)
        return f"give their units with --unit {names}"
    return f"give {' or '.join(options)}" + (", whichever is wrong" if len(options) > 1 else "")


def _scaled(reading: Reading, role: str, factor: float) -> str:
    """Return the option that multiplies a signal by a factor."""
    scale = reading.description.column(role).scale
    before = "" if scale is None else f"{scale}*"
    return f"--scale {role}={before}{factor:.4g}"


def _unit_for(reading: Reading, role: str, factor: float) -> Unit | None:
    """Return the unit that is ``factor`` times as large as that in which a signal was read."""
    key, unit = quantity_key(role), reading.units[role]
    motions = [reading.recording.motion] if any(reading.units.values()) else list(QUANTITIES)
    quantities = ["time"] if key == "time" else [QUANTITIES[motion][key] for motion in motions]
    return sized_unit(quantities, factor * (unit.factor if unit else 1.0))
