"""Figures of a log that hardly any drive has, and signals that contradict each other by units."""

import math
from collections.abc import Iterator

import numpy as np
import scipy

from stickslip.logs.excitation import excitation, is_one_way
from stickslip.logs.motion import FARTHEST, Kinematics, basis, kinematics
from stickslip.logs.reading import Reading
from stickslip.logs.recording import Finding, Motion, Recording
from stickslip.logs.units import (
    QUANTITIES,
    Unit,
    described_ratio,
    near_factor,
    quantity_key,
    sized_unit,
)
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import log_content, log_unit

RATE = "d(position)/dt"
DIFFER = "differ in scale"  # of two signals, by a factor near none that is known
DELAYS = 9  # delays of the force that are tried
LATE, FILTERED = 0.1, 0.01  # share of the log by which a signal, and a velocity, may be late
CUTOFF = 0.02  # of the low-pass before a comparison, in sampling frequencies


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
    held = {"position", "force"} <= set(signals) and _is_spring(
        signals["position"], signals["force"]
    )
    for a, b, most, late in (
        (RATE, "velocity", log_unit.EQUALS, FILTERED),
        ("position", "position_command", log_unit.FOLLOWS, LATE),
        (speed, "velocity_command", log_unit.FOLLOWS, LATE),
        ("force", "force_command", log_unit.FOLLOWS, LATE),
    ):
        if a not in signals or b not in signals:
            continue
        if (best := _unlike(signals, a, b, late)) is not None:
            figure = f"a correlation of {best:.2f}; expected at least {log_unit.UNLIKE:g}"
            yield _unrelated(b, a, figure)
        ratio, high, low = _likeness(signals[a], signals[b], late)
        if high >= log_unit.IMAGE:
            # Friction holds a drive before break-away as a spring does, whatever the command.
            sure = math.inf if held and b.endswith("_command") else most
            yield from _contradiction(reading, a, b, (ratio, high), most=sure)
        elif low <= -log_unit.SURE_IMAGE and high < log_unit.IMAGE / 2:
            yield from _contradiction(reading, a, b, (-ratio, -low), most=most)
    share = 1.0
    if "force" in signals and (force := recording.force) is not None and not held:
        force = smoothed(recording.moving(force), recording.T_s, motion.cutoff)
        share = _shared(recording, force, motion)
    if share < log_unit.SHARED:
        figure = f"{share:.1%} of it is like inertia, viscous and Coulomb friction of that motion"
        figure += f"; expected at least {log_unit.SHARED:.0%}"
        yield _unrelated("force", "the motion", figure)
    if T_s := reading.controller.T_s:
        ratio = recording.T_s / T_s
        if not 1 / log_unit.SLOWER <= ratio <= log_unit.FASTER:
            what = "the log's time and the controller's T_s contradict each other"
            figure = f"{recording.T_s:.4g} s and {T_s:.4g} s, a factor of {described_ratio(ratio)}"
            advice = "the gain T_s is in s; a unit of the log's time is set by <unit time=ms>"
            yield Finding("error", what, figure, advice)


def _is_spring(position: Array, force: Array) -> bool:
    """Tell whether a force (n,) [N] is an image of the position, as before break-away."""
    place, held = position - position.mean(), force - force.mean()
    sizes = float(np.linalg.norm(place)) * float(np.linalg.norm(held))
    return sizes > 0.0 and float(place @ held) >= log_unit.SURE_IMAGE * sizes


def _unrelated(b: str, a: str, figure: str) -> Finding:
    """Return the error of a signal that has nothing in common with another."""
    advice = f"choose the column of the same axis with <column {b}=NAME>"
    if b != "force":
        advice = f"{advice}; <column {b}=none> leaves it out"
    return Finding("error", f"{b} is unrelated to {a}", figure, advice)


def _shared(recording: Recording, force: Array, motion: Kinematics) -> float:
    """Return the share of a force (n,) like that of a rigid drive, 1 where that is not known.

    It is not where the drive hardly moves, or in one direction only: a force that rises until the
    drive breaks away is not like its motion. The force may be late; most of a chance likeness is
    that of slow motions.
    """
    moving = np.abs(motion.v) > motion.floor
    if np.mean(moving) < log_unit.MOVING or is_one_way(kinematics(recording)):
        return 1.0
    way = smoothed(np.sign(motion.v) * moving, recording.T_s, motion.cutoff)
    columns, _ = basis(np.column_stack([np.ones_like(way), motion.v, motion.a, way]))
    varying = force - force.mean()
    varying = varying / max(float(np.max(np.abs(varying))), 1e-300)
    delays = np.linspace(-FARTHEST, FARTHEST, DELAYS) / recording.T_s
    found = (columns.T @ np.roll(varying, -round(delay)) for delay in delays)
    return max(float(one @ one) for one in found) / max(float(varying @ varying), 1e-300)


def _likeness(a: Array, b: Array, late: float) -> tuple[float, float, float]:
    """Return how many times larger b (n,) is than a (n,), and their extreme correlations.

    The ratio of standard deviations is that of regression both ways, and needs no alignment; the
    correlations are those at the best lag, and at the best lag of one inverted. The farthest
    thousandths of the samples are cut off.
    """
    a, b = (np.clip(s, *np.quantile(s, (0.001, 0.999))) for s in (a, b))
    a, b = a - a.mean(), b - b.mean()
    sizes = float(np.std(a)), float(np.std(b))
    if min(sizes) == 0:
        return np.nan, np.nan, np.nan
    reach = int(late * len(a))
    n = scipy.fft.next_fast_len(2 * len(a) - 1, real=True)
    both = scipy.fft.rfft(b / sizes[1], n) * scipy.fft.rfft(a[::-1] / sizes[0], n)
    lags = scipy.fft.irfft(both, n)[len(a) - 1 - reach : len(a) + reach] / len(a)
    return sizes[1] / sizes[0], float(lags.max()), float(lags.min())


def _unlike(signals: dict[str, Array], a: str, b: str, late: float) -> float | None:
    """Return the correlation of a signal b with a, if none shows that both are of one axis.

    The command of a drive that sticks is unlike its motion, but not unlike the force.
    """
    others = [a, "force"] if a != "force" and "command" in b and "force" in signals else [a]
    found = [_likeness(signals[one], signals[b], late)[1:] for one in others]
    best = max(max(high, -low) for high, low in found)
    return best if best < log_unit.UNLIKE else None


def _contradiction(
    reading: Reading, a: str, b: str, image: tuple[float, float], most: float
) -> Iterator[Finding]:
    """Yield the findings of two signals if b, an image of a, is not as large."""
    ratio, likeness = image
    what = f"{a} and {b} contradict each other"
    leave = f"<column {b}=none> leaves {b} out"
    if ratio < 0:
        figure = f"they have opposite signs, {b} is {ratio:.4g} times {a}"
        yield Finding("error", what, figure, f"{_turned(reading, b, a)}; {leave}")
    figure = f"{b} is {abs(ratio):.4g} times {a}"
    factor, name = near_factor(abs(ratio)) or (0.0, "")
    is_small = 1 / log_unit.SMALL < factor < log_unit.SMALL
    if factor and (likeness > log_unit.SURE_IMAGE or not is_small):
        ends = {b: 1 / factor, a: factor}
        if a == RATE:
            ends = {b: 1 / factor, "position": factor, "time": 1 / factor}
        advice = _corrections(reading, ends)
        yield Finding("error", what, f"{figure}, near {name}", f"{advice}; {leave}")
    elif b.endswith("_command") and likeness < log_unit.SURE_IMAGE:
        return  # a drive that sticks follows its command by a part of it
    elif not 1 / most <= abs(ratio) <= most:
        advice = f"a gear or the pitch of a screw is set by {_scaled(reading, b, 1 / abs(ratio))}"
        what = f"{a} and {b} {DIFFER}"
        yield Finding("warning", what, figure, f"{advice}; {leave}", spoils="values")


def _corrections(reading: Reading, ends: dict[str, float]) -> str:
    """Return settings that multiply one of several signals, by role, by its factor."""
    units = reading.units
    options = []
    known = [role for role in ends if role in units]
    for role in sorted(known, key=lambda role: units[role] is not None):  # unstated ones first
        if reading.description.column(role).scale is not None:
            options.append(_scaled(reading, role, ends[role]))
        elif unit := _unit_for(reading, role, ends[role]):
            options.append(f"<unit {role}={unit.name}>")
    if not options:
        return f"give their units with <unit {' '.join(f'{role}=UNIT' for role in known)}>"
    return f"give {' or '.join(options)}" + (", whichever is wrong" if len(options) > 1 else "")


def correction(reading: Reading, factor: float) -> str:
    """Return settings that make the force ``factor`` times as large, or the motion smaller."""
    unit = _unit_for(reading, "force", factor)
    if unit and reading.description.column("force").scale is None:
        options = [f"<unit force={unit.name}>"]
    else:
        options = [_scaled(reading, "force", factor)]
    moved = {
        role: one.name
        for role in reading.assumed
        if role.startswith(("position", "velocity"))
        and (one := _unit_for(reading, role, 1 / factor))
    }
    if {"position", "velocity"} & moved.keys():
        options.insert(0, f"<unit {' '.join(f'{role}={name}' for role, name in moved.items())}>")
    return " or ".join(options) + (", whichever is wrong" if len(options) > 1 else "")


def _scaled(reading: Reading, role: str, factor: float) -> str:
    """Return the setting that multiplies a signal by a factor."""
    scale = reading.description.column(role).scale
    before = "" if scale is None else f"{scale}*"
    return f"<scale {role}={before}{factor:.4g}>"


def _turned(reading: Reading, *roles: str) -> str:
    """Return the advice to turn the sign of one of some signals."""
    own = ("position" if role == RATE else role for role in roles)
    options = " or ".join(_scaled(reading, role, -1) for role in own)
    return f"turn the sign of the one that is wrong with {options}"


def _unit_for(reading: Reading, role: str, factor: float) -> Unit | None:
    """Return the unit that is ``factor`` times as large as that in which a signal was read."""
    key, unit = quantity_key(role), reading.units[role]
    motions = [reading.recording.motion] if any(reading.units.values()) else list(QUANTITIES)
    quantities = ["time"] if key == "time" else [QUANTITIES[motion][key] for motion in motions]
    return sized_unit(quantities, factor * (unit.factor if unit else 1.0))


LIMITS: dict[Motion, dict[str, tuple[float, float, float, float]]] = {
    "linear": {
        "mass": (1e-3, 2e-2, 2e4, 1e5),  # kg
        "speed": (0.0, 0.0, 10.0, 100.0),  # m/s
        "acceleration": (0.0, 0.0, 300.0, 9806.65),  # m/s^2
        "force": (0.0, 0.0, 1e5, 1e7),  # N
    },
    "rotary": {
        "mass": (1e-9, 1e-7, 1e4, 1e6),
        "speed": (0.0, 0.0, 2000.0, 1e4),
        "acceleration": (0.0, 0.0, 1e5, 1e6),
        "force": (0.0, 0.0, 1e5, 1e7),
    },
}
"""Figures beyond the outer two must be confirmed, those beyond the inner two are asked about."""
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
        turned = "" if recording.rotary else f", <unit {moved}=rad{suffix}> of a rotary drive,"
        advice = (
            f"give <unit {moved}=mm{suffix}>{turned} or <unit {moved}={unit}{suffix}> if it is so"
        )
        yield Finding("error", "the travel is very long", figure, advice)
    if moved not in reading.units or not reading.timed:
        return  # an error already
    kg, N = ("kg m^2", "N m") if recording.rotary else ("kg", "N")
    figures = {
        "speed": (float(np.quantile(np.abs(motion.v), 0.99)), f"{unit}/s"),
        "acceleration": (shown.acceleration, f"{unit}/s^2"),
    }
    if recording.force is not None and "force" in reading.units:
        largest = float(np.quantile(np.abs(recording.force), 0.99))
        figures["force"] = largest, N
        work = float(recording.force[1:] @ np.diff(motion.x))
        seen, m, F_c = shown.inertial > log_content.INERTIAL, shown.mass, shown.coulomb
        if seen and m < 0.0 and F_c < 0.0 and work < 0.0:
            figure = f"F = m a + b v + F_c sign(v) gives m = {m:.3g} {kg} and F_c = {F_c:.3g} {N}"
            advice = _turned(reading, "force", moved)
            yield Finding("error", "the force acts against the motion", figure, advice)
        elif seen and m > 0.0:
            figures["mass"] = m, kg
    for name, (value, per) in figures.items():
        if question := _asked(reading, name, value, value, unit=per):
            yield question


def implausible_mass(reading: Reading, low: float, high: float) -> Finding | None:
    """Return the finding on a mass between two values [kg] that hardly any drive has."""
    unit = "kg m^2" if reading.recording.rotary else "kg"
    return _asked(reading, "mass", low, high, unit=unit) if high > 0.0 else None


def _asked(reading: Reading, name: str, low: float, high: float, unit: str) -> Finding | None:
    """Return the finding on a figure, between two values, beyond its limits."""
    least, small, large, most = LIMITS[reading.recording.motion][name]
    if not (gross := high < least or low > most):
        least, most = small, large
    if high < least:
        figure = f"{high:.4g} {unit}, less than {least:g} {unit}"
    elif low > most:
        figure = f"{low:.4g} {unit}, more than {most:g} {unit}"
    else:
        return None
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
