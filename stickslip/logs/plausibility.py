"""Figures of a log that hardly any drive has: units that are missing or wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from stickslip.logs.contradictions import contradictions
from stickslip.logs.excitation import excitation
from stickslip.logs.finding import Finding
from stickslip.logs.motion import kinematics
from stickslip.logs.reading import Reading
from stickslip.logs.recording import Motion

SHOWN = 0.05
"""Share of the force that inertia makes, from which the mass shows."""


class _Limits(NamedTuple):
    least_mass: float  # kg
    most_mass: float
    speed: float  # m/s
    acceleration: float  # m/s^2
    travel: float  # of a position that states no unit [m]


LIMITS: dict[Motion, _Limits] = {
    "linear": _Limits(1e-3, 1e5, 100.0, 9806.65, 2.0),
    "rotary": _Limits(1e-9, 1e6, 1e4, 1e6, math.inf),
}
"""Figures beyond these must be confirmed."""
SLOWEST = 0.05
"""Sample period [s] beyond which a time that states no unit is asked about."""


def check_units(reading: Reading) -> tuple[Finding, ...]:
    """Return signals that contradict each other by a factor of units, and extreme figures."""
    return (*contradictions(reading), *implausible(reading))


def implausible(reading: Reading) -> Iterator[Finding]:
    """Yield extreme figures, as errors until they are corrected or confirmed."""
    recording, assumed = reading.recording, reading.assumed
    limits = LIMITS[recording.motion]
    if "time" in assumed and recording.T_s > SLOWEST:
        figure = f"{recording.T_s:.4g} s from one sample to the next, and time states no unit"
        advice = "give --unit time=ms, or --unit time=s if it is so"
        yield Finding("error", "the sampling is very slow", figure, advice)
    shown, motion = excitation(recording), kinematics(recording)
    unit = "rad" if recording.motion == "rotary" else "m"
    moved, suffix = ("velocity", "/s") if recording.position is None else ("position", "")
    if moved in assumed and (travel := float(np.ptp(motion.x))) > limits.travel:
        figure = f"{travel:.4g} {unit}, and {moved} states no unit"
        advice = f"give --unit {moved}=mm{suffix}, or --unit {moved}={unit}{suffix} if it is so"
        yield Finding("error", "the travel is very long", figure, advice)
    if moved not in reading.units or not reading.timed:
        return  # an error already
    fast = float(np.quantile(np.abs(motion.v), 0.99))
    for name, value, limit, per in (
        ("speed", fast, limits.speed, "/s"),
        ("acceleration", shown.acceleration, limits.acceleration, "/s^2"),
    ):
        if value > limit:
            figure = f"{value:.4g} {unit}{per}, more than {limit:.4g} {unit}{per}"
            yield _extreme(reading, name, figure)
    mass = shown.mass if shown.inertial > SHOWN and "force" in reading.units else np.nan
    if question := implausible_mass(reading, mass, mass):
        yield question


def implausible_mass(reading: Reading, low: float, high: float) -> Finding | None:
    """Return the finding on a mass between two values [kg] that hardly any drive has."""
    unit = "kg m^2" if reading.recording.motion == "rotary" else "kg"
    least, most, *_ = LIMITS[reading.recording.motion]
    if 0 < high < least:
        return _extreme(reading, "mass", f"{high:.3g} {unit}, less than {least:g} {unit}")
    if low > most:
        return _extreme(reading, "mass", f"{low:.3g} {unit}, more than {most:g} {unit}")
    return None


def _extreme(reading: Reading, name: str, figure: str) -> Finding:
    """Return a figure's error, or its note where it is confirmed."""
    if name in reading.description.confirm:
        return Finding("note", f"the {name} is extreme, and confirmed", figure)
    roles = [r for r in ("time", "position", "velocity", "force") if r in reading.units]
    unstated = [role for role in roles if role in reading.assumed]
    options = " ".join(f"{role}=UNIT" for role in unstated or roles)
    why = " (none is stated)" if unstated else " or the scales"
    advice = f"correct the units{why}, --unit {options}, or give --confirm {name}"
    return Finding("error", f"the {name} is extreme", figure, advice)
