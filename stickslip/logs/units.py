"""Units that logs are written in.

Rotary drives have angles for lengths and torques for forces. What is no mechanical quantity
(currents, voltages, counts) needs a scale that says what it stands for.
"""

import math
import re
from collections.abc import Collection
from dataclasses import dataclass

from stickslip.errors import UsageError
from stickslip.logs.recording import Motion
from stickslip.thresholds import log_unit

_TURN = 2 * math.pi
_INCH = 0.0254
_POUND = 4.4482216152605

_FACTORS: dict[str, dict[str, float]] = {
    "time": {
        "s": 1, "sec": 1, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "100 ns": 1e-7, "min": 60, "h": 3600,
    },
    "length": {
        "m": 1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9,
        "inch": _INCH, "in": _INCH, "mil": _INCH / 1000, "ft": 12 * _INCH,
    },
    "angle": {
        "rad": 1, "mrad": 1e-3, "urad": 1e-6, "deg": _TURN / 360, "°": _TURN / 360,
        "arcmin": _TURN / 21600, "arcsec": _TURN / 1296000, "rev": _TURN, "turn": _TURN,
        "mdeg": _TURN / 360e3, "mrev": _TURN / 1e3,
    },
    "speed": {
        "m/s": 1, "cm/s": 1e-2, "mm/s": 1e-3, "um/s": 1e-6, "nm/s": 1e-9, "mm/min": 1e-3 / 60,
        "m/min": 1 / 60, "inch/s": _INCH, "in/s": _INCH, "km/h": 1 / 3.6,
    },
    "angular speed": {
        "rad/s": 1, "mrad/s": 1e-3, "deg/s": _TURN / 360, "°/s": _TURN / 360, "rpm": _TURN / 60,
        "1/min": _TURN / 60, "rev/min": _TURN / 60, "rev/s": _TURN, "Hz": _TURN,
        "krpm": _TURN * 1e3 / 60,
    },
    "acceleration": {
        "m/s^2": 1, "cm/s^2": 1e-2, "mm/s^2": 1e-3, "um/s^2": 1e-6, "in/s^2": _INCH, "g": 9.80665,
    },
    "angular acceleration": {
        "rad/s^2": 1, "deg/s^2": _TURN / 360, "°/s^2": _TURN / 360, "rev/s^2": _TURN,
    },
    "jerk": {"m/s^3": 1, "cm/s^3": 1e-2, "mm/s^3": 1e-3, "um/s^3": 1e-6, "in/s^3": _INCH},
    "angular jerk": {
        "rad/s^3": 1, "deg/s^3": _TURN / 360, "°/s^3": _TURN / 360, "rev/s^3": _TURN,
    },
    "force": {
        "N": 1, "mN": 1e-3, "uN": 1e-6, "kN": 1e3, "lbf": _POUND, "kgf": 9.80665,
        "gf": 9.80665e-3, "ozf": _POUND / 16, "cN": 1e-2, "daN": 10,
    },
    "torque": {"N.m": 1, "mN.m": 1e-3, "uN.m": 1e-6, "kN.m": 1e3, "N.cm": 1e-2, "N.mm": 1e-3},
    "current": {"A": 1, "mA": 1e-3, "Arms": 1},
    "voltage": {"V": 1, "mV": 1e-3, "kV": 1e3},
    "number": {
        "1": 1, "%": 1e-2, "‰": 1e-3, "counts": 1, "count": 1, "cts": 1, "inc": 1, "increments": 1,
        "LU": 1, "lsb": 1,
    },
    "number per time": {"counts/s": 1},
}  # fmt: skip
_SPELT = {
    "Nm": "N.m", "mNm": "mN.m", "uNm": "uN.m", "kNm": "kN.m", "Ncm": "N.cm", "Nmm": "N.mm",
    "cNm": "cN.m", "ozin": "ozf.in", "inlb": "lbf.in", "ftlb": "lbf.ft", "kgcm": "kgf.cm",
    "A_rms": "Arms", "A.rms": "Arms", "Aeff": "Arms", "amp": "A", "ampere": "A", "volt": "V",
    "newton": "N", "lb": "lbf", "lbs": "lbf", "oz": "ozf", "second": "s", "sek": "s", "Sek.": "s",
    "msec": "ms", "millis": "ms", "millisec": "ms", "millisecond": "ms", "usec": "us",
    "micros": "us", "microsec": "us", "microsecond": "us", "nsec": "ns", "nanosec": "ns",
    "nanosecond": "ns", "micron": "um", "inches": "inch", "degree": "deg", "Grad": "deg",
    "grd": "deg", "radian": "rad", "revolution": "rev", "rotation": "rev", "rot": "rev",
    "Umdr": "rev", "Umdr.": "rev", "min^-1": "1/min", "min-1": "1/min", "min⁻¹": "1/min",
    "U/min": "rpm", "U/s": "rev/s", "r/min": "rpm", "r/s": "rev/s", "tr/min": "rpm",
    "tr/s": "rev/s", "rps": "rev/s", "mps": "m/s", "mmps": "mm/s", "dps": "deg/s",
    "degps": "deg/s", "radps": "rad/s", "cps": "counts/s", "pps": "counts/s", "cnt": "counts",
    "qc": "counts", "tick": "counts", "pulse": "counts", "sample": "counts", "Inkr": "inc",
    "Inkr.": "inc", "Ink": "inc", "increment": "inc", "percent": "%", "pct": "%",
    "permille": "‰", "0.1 %": "‰", "0.1%": "‰", "0,1 %": "‰", "0,1%": "‰", "1/1000": "‰",
}  # fmt: skip

QUANTITIES: dict[Motion, dict[str, str]] = {
    "linear": {
        "position": "length", "velocity": "speed", "force": "force",
        "acceleration": "acceleration", "jerk": "jerk",
    },
    "rotary": {
        "position": "angle", "velocity": "angular speed", "force": "torque",
        "acceleration": "angular acceleration", "jerk": "angular jerk",
    },
}  # fmt: skip
"""What a drive's signals are by its motion."""

_CASE_COUNTS = frozenset({"force", "torque", "current", "voltage"})


@dataclass(frozen=True)
class Unit:
    """A unit: value in SI units = factor * value."""

    name: str  # as it is written here
    quantity: str  # what it measures
    factor: float


_UNITS = {
    name: Unit(name, quantity, float(factor))
    for quantity, factors in _FACTORS.items()
    for name, factor in factors.items()
}

_ALIKE: dict[str, set[Unit]] = {}
for _name in (*_UNITS, *_SPELT):
    if (_spelt := _SPELT.get(_name, _name)) in _UNITS:
        _ALIKE.setdefault(_name.lower(), set()).add(_UNITS[_spelt])
_PER_TIME = {"length": "speed", "angle": "angular speed", "number": "number per time"}
_WEIGHTS = {"kg": "kgf", "g": "gf"}  # forces of torques in kg.cm


def unit_named(text: str) -> Unit | None:
    """Return the unit that people write so, None when there is none.

    Upper and lower case count (mN and MN, nm and Nm), except where only one unit is meant. A rate
    such as turns/s and a torque such as oz-in are composed of their parts; a plural is its unit.
    """
    name = text.strip().replace("μ", "u").replace("µ", "u").replace("²", "^2").replace("³", "^3")
    name = re.sub(r"(?<=/s)(?=[23]$)", "^", name)
    name = _SPELT.get(name, name)
    for sign in "·*⋅- ":
        if name not in _UNITS:
            name = name.replace(sign, ".")
    if name in _UNITS:
        return _UNITS[name]
    alike = _ALIKE.get(name.lower(), set())
    found = next(iter(alike)) if len(alike) == 1 else None
    if found and (len(name) > 2 or found.quantity not in _CASE_COUNTS):
        return found
    plural = len(name) > 3 and name.endswith("s")
    return _composed(name) or (unit_named(name[:-1]) if plural else None)


def _composed(name: str) -> Unit | None:
    """Return a length, an angle or a number per time, or a force times a length."""
    sign = "/" if "/" in name else "."
    parts = [_WEIGHTS.get(part, part) if sign == "." else part for part in name.split(sign) if part]
    first, second = map(unit_named, parts) if len(parts) == 2 else (None, None)
    if first is None or second is None:
        return None
    if sign == "/" and second.quantity == "time" and first.quantity in _PER_TIME:
        return Unit(name, _PER_TIME[first.quantity], first.factor / second.factor)
    if sign == "." and {first.quantity, second.quantity} == {"force", "length"}:
        return Unit(name, "torque", first.factor * second.factor)
    return None


def unit_fitting(text: str, quantities: Collection[str]) -> Unit | None:
    """Return the unit that people write so; in any case where only then it fits quantities."""
    unit = unit_named(text)
    if unit and unit.quantity in quantities:
        return unit
    alike = [unit for unit in _ALIKE.get(text.lower(), ()) if unit.quantity in quantities]
    return alike[0] if len(alike) == 1 else unit


def parse_quantity(text: str, what: str, quantities: Collection[str]) -> tuple[float, Unit | None]:
    """Return the SI value of a text such as 100mm or 2.5 rev/s, and its unit; None is SI.

    Raises UsageError, which names what is given, when there is no number, or the unit measures none
    of the quantities, such as length and angle.
    """
    match = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*", text)
    unit = unit_named(match[2]) if match and match[2] else None
    if not match or (match[2] and (unit is None or unit.quantity not in quantities)):
        names = ", ".join(name for one in quantities for name in unit_names(one)[:3])
        raise UsageError(f"{what} = {text}: expected a number, with a unit such as {names}")
    return float(match[1]) * (unit.factor if unit else 1.0), unit


def sized_unit(quantities: Collection[str], factor: float) -> Unit | None:
    """Return the first unit of some quantities that is as large, None when there is none."""
    return next(
        (
            unit
            for unit in _UNITS.values()
            if unit.quantity in quantities and abs(math.log(unit.factor / factor)) < 0.01
        ),
        None,
    )


def unit_names(quantity: str) -> tuple[str, ...]:
    """Return the names of the units of a quantity."""
    return tuple(_FACTORS.get(quantity, ()))


def motion_of(unit: Unit) -> Motion | None:
    """Return the motion that a unit belongs to, None when to either."""
    return next((m for m, of in QUANTITIES.items() if unit.quantity in of.values()), None)


def quantity_key(role: str) -> str:
    """Return what the role of a column measures: time, position, velocity or force."""
    key = role.removesuffix("_command").removeprefix("added_")
    return "force" if key == "friction" else key


def quantity_of(role: str, motion: Motion) -> str:
    """Return the quantity of a role's units in a motion."""
    return "time" if role == "time" else QUANTITIES[motion][quantity_key(role)]


def quantities_of(role: str) -> frozenset[str]:
    """Return the quantities of a role's units in all motions."""
    return frozenset(quantity_of(role, motion) for motion in QUANTITIES)


def expected_units(role: str, motion: Motion | None = None) -> str:
    """Return the commonest units of a role."""
    motions = [motion] if motion else list(QUANTITIES)
    names = [name for m in motions for name in unit_names(quantity_of(role, m))[:4]]
    return ", ".join(dict.fromkeys(names))


FACTORS = {
    "2 pi": _TURN, "60/2 pi": 60 / _TURN, "25.4": 25.4, "39.37": 1 / 0.0254, "60": 60.0,
    "360/2 pi": 360 / _TURN, "360": 360.0, "10^3": 1e3, "60*10^3": 6e4, "10^6": 1e6, "10^9": 1e9,
}  # fmt: skip
"""Between units that are often confused: m, mm, inch; rad, deg, turns; s, min, ms."""


def near_factor(ratio: float) -> tuple[float, str] | None:
    """Return the factor of units, or its inverse, that a ratio > 0 is near, and how to write it."""
    size = abs(math.log(ratio))
    name, value = min(FACTORS.items(), key=lambda item: abs(math.log(item[1]) - size))
    if abs(math.log(value) - size) > (log_unit.ROUGHLY if value > 100 else log_unit.NEAR):
        return None
    return (value, name) if ratio > 1 else (1 / value, f"1/({name})")


def described_ratio(ratio: float) -> str:
    """Return a ratio, and the factor of units that it is near."""
    factor = near_factor(ratio)
    return f"{ratio:.4g}" + (f", near {factor[1]}" if factor else "")
