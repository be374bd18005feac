"""Figures of a log that hardly any drive has: units that are missing or wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from stickslip.logs.contradictions import contradictions
from stickslip.logs.excitation import excitation
from stickslip.logs.finding import Finding
from stickslip.logs.motion import kinematics
from stickslip.logs.reading import Reading
from stickslip.logs.recording import Motion
from stickslip.thresholds import log_content, log_unit

_Limits = dict[str, tuple[float, float]]

GROSS: dict[Motion, _Limits] = {
    "linear": {
        "mass": (1e-3, 1e5),  # kg
        "speed": (0.0, 100.0),  # m/s
        "acceleration": (0.0, 9806.65),  # m/s^2
        "force": (0.0, 1e7),  # N
    },
    "rotary": {
        "mass": (1e-9, 1e6),
        "speed": (0.0, 1e4),
        "acceleration": (0.0, 1e6),
        "force": (0.0, 1e7),
    },
}
"""Figures beyond these must be confirmed."""
UNUSUAL: dict[Motion, _Limits] = {
    "linear": {
        "mass": (2e-2, 2e4),
        "speed": (0.0, 10.0),
        "acceleration": (0.0, 300.0),
        "force": (0.0, 1e5),
    },
    "rotary": {
        "mass": (1e-7, 1e4),
        "speed": (0.0, 2000.0),
        "acceleration": (0.0, 1e5),
        "force": (0.0, 1e5),
    },
}
"""Figures beyond these are asked about."""
LONGEST: dict[Motion, float] = {"linear": 2.0, "rotary": math.inf}
"""Travel [m] beyond which a position that states no unit is asked about."""


def check_units(reading: Reading) -> tuple[Finding, ...]:
    """Return signals that contradict each other by a factor of units, and extreme figures."""
    return (*contradictions(reading), *implausible(reading))


def implausible(reading: Reading) -> Iterator[Finding]:
    """Yield extreme figures, as errors until they are corrected or confirmed."""
    recording, assumed = reading.recording, reading.assumed
    if "time" in assumed and recording.T_s > log_unit.SLOWEST:
        figure = f"{recording.T_s:.4g} s from one sample to the next, and time states no unit"
        advice = "give <unit time=ms>, or <unit time=s> if it is so"
        yield Finding("error", "the sampling is very slow", figure, advice)
    shown, motion = excitation(recording), kinematics(recording)
    unit = "rad" if recording.rotary else "m"
    moved, suffix = ("velocity", "/s") if recording.position is None else ("position", "")
    if moved in assumed and (travel := float(np.ptp(motion.x))) > LONGEST[recording.motion]:
        figure = f"{travel:.4g} {unit}, and {moved} states no unit"
        advice = f"give <unit {moved}=mm{suffix}>, or <unit {moved}={unit}{suffix}> if it is so"
        yield Finding("error", "the travel is very long", figure, advice)
    if moved not in reading.units or not reading.timed:
        return  # an error already
    rotary = recording.rotary
    figures = {
        "speed": (float(np.quantile(np.abs(motion.v), 0.99)), f"{unit}/s"),
        "acceleration": (shown.acceleration, f"{unit}/s^2"),
    }
    if recording.force is not None and "force" in reading.units:
        largest = float(np.quantile(np.abs(recording.force), 0.99))
        figures["force"] = largest, "N m" if rotary else "N"
        work = float(recording.force[1:] @ np.diff(motion.x))
        seen = shown.inertial > log_content.INERTIAL
        if seen and shown.mass < 0.0 and shown.coulomb < 0.0 and work < 0.0:
            yield _against_motion(reading, shown.mass, shown.coulomb)
        elif seen and shown.mass > 0.0:
            figures["mass"] = shown.mass, "kg m^2" if rotary else "kg"
    for name, (value, per) in figures.items():
        if question := _asked(reading, name, value, value, unit=per):
            yield question


def _against_motion(reading: Reading, mass: float, coulomb: float) -> Finding:
    """Return the error of a force whose sign is not that of the position."""
    kg, N = ("kg m^2", "N m") if reading.recording.rotary else ("kg", "N")
    figure = f"F = m a + b v + F_c sign(v) gives m = {mass:.3g} {kg} and F_c = {coulomb:.3g} {N}"
    scale = reading.description.column("force").scale
    before = "" if scale is None else f"{scale}*"
    advice = f"give <scale force={before}-1>, which turns its sign"
    return Finding("error", "the force acts against the motion", figure, advice)


def implausible_mass(reading: Reading, low: float, high: float) -> Finding | None:
    """Return the finding on a mass between two values [kg] that hardly any drive has."""
    unit = "kg m^2" if reading.recording.rotary else "kg"
    return _asked(reading, "mass", low, high, unit=unit) if high > 0.0 else None


def _asked(reading: Reading, name: str, low: float, high: float, unit: str) -> Finding | None:
    """Return the finding on a figure, between two values, beyond its limits."""
    for limits in (GROSS, UNUSUAL):
        least, most = limits[reading.recording.motion][name]
        if high < least:
            figure = f"{high:.4g} {unit}, less than {least:g} {unit}"
        elif low > most:
            figure = f"{low:.4g} {unit}, more than {most:g} {unit}"
        else:
            continue
        return _extreme(reading, name, figure, gross=limits is GROSS)
    return None


def _extreme(reading: Reading, name: str, figure: str, *, gross: bool) -> Finding:
    """Return a figure's error or warning, or its note where it is confirmed."""
    if name in reading.description.confirm:
        return Finding("note", f"the {name} is extreme, and confirmed", figure)
    roles = [r for r in ("time", "position", "velocity", "force") if r in reading.units]
    unstated = [role for role in roles if role in reading.assumed]
    options = " ".join(f"{role}=UNIT" for role in unstated or roles)
    why = " (none is stated)" if unstated else " or the scales"
    advice = f"correct the units{why}, <unit {options}>, or give <confirm {name}>"
    if gross:
        return Finding("error", f"the {name} is extreme", figure, advice)
    return Finding("warning", f"the {name} is unusual", figure, advice, spoils="intervals")
