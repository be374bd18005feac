"""Units as exponents of SI base units: those of our models, and what is made of known symbols."""

import math
import re
from collections.abc import Mapping
from typing import Any

BaseUnit = dict[str, float]
"""Exponents of base units; ``factor`` where the unit is not made of these alone."""
# symbol -> factor and exponents of kg, m, s, A, K, mol, cd, rad
_BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_SYMBOLS: dict[str, tuple[float, tuple[int, ...]]] = {
    "g": (1e-3, (1,)),
    **{name: (1.0, (*[0] * k, 1)) for k, name in enumerate(_BASE) if k},
    "Hz": (1.0, (0, 0, -1)),
    "N": (1.0, (1, 1, -2)),
    "Pa": (1.0, (1, -1, -2)),
    "J": (1.0, (1, 2, -2)),
    "W": (1.0, (1, 2, -3)),
    "C": (1.0, (0, 0, 1, 1)),
    "V": (1.0, (1, 2, -3, -1)),
    "F": (1.0, (-1, -2, 4, 2)),
    "Ohm": (1.0, (1, 2, -3, -2)),
    "Wb": (1.0, (1, 2, -2, -1)),
    "T": (1.0, (1, 0, -2, -1)),
    "H": (1.0, (1, 2, -2, -2)),
    "bar": (1e5, (1, -1, -2)),
    "l": (1e-3, (0, 3)),
}
_WHOLE: dict[str, tuple[float, tuple[int, ...]]] = {  # take no prefix
    "1": (1.0, ()),
    "%": (1e-2, ()),
    "min": (60.0, (0, 0, 1)),
    "h": (3600.0, (0, 0, 1)),
    "deg": (math.pi / 180, (0, 0, 0, 0, 0, 0, 0, 1)),
    "rpm": (math.pi / 30, (0, 0, -1, 0, 0, 0, 0, 1)),
}
_PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "d": 0.1, "c": 1e-2, "m": 1e-3}
_PREFIXES |= {"u": 1e-6, "\N{MICRO SIGN}": 1e-6, "n": 1e-9, "p": 1e-12}
_FACTOR = re.compile(r"([./*]|^)([^\W\d]+|%|1)\^?(-?\d+)?")


def base_unit(unit: str) -> BaseUnit | None:
    """Return a unit as exponents of base units, None where it is not made of known symbols.

    Symbols are joined by ``.`` or ``*``, a ``/`` inverts the one behind it: ``N.s/m``, ``rad/s2``.
    """
    text = unit.replace(" ", ".")
    factor, exponents, end = 1.0, [0] * len(_BASE), 0
    for match in _FACTOR.finditer(text):
        symbol = _symbol(match[2])
        if match.start() != end or symbol is None:
            return None
        power = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        factor *= symbol[0] ** power
        for k, exponent in enumerate(symbol[1]):
            exponents[k] += power * exponent
        end = match.end()
    if end != len(text) or not end:
        return None
    base: BaseUnit = {name: n for name, n in zip(_BASE, exponents, strict=True) if n}
    return base if factor == 1.0 else {**base, "factor": factor}


def _symbol(text: str) -> tuple[float, tuple[int, ...]] | None:
    if found := _WHOLE.get(text) or _SYMBOLS.get(text):
        return found
    factor, scaled = _PREFIXES.get(text[0]), _SYMBOLS.get(text[1:])
    return (factor * scaled[0], scaled[1]) if factor and scaled else None


_NAMES = "1 kg m m/s m/s2 N N2 N/m N.s/m N/s N/m/s s 1/s"
UNITS = {name: base_unit(name) or {} for name in _NAMES.split()}
"""Units of models and laws -> exponents of base units."""
RANGES = {
    "N": (1e-15, 1e15),
    "m": (1e-15, 1e9),
    "m/s": (1e-15, 1e9),
    "kg": (1e-18, 1e12),
    "N/m": (1e-12, 1e18),
    "N.s/m": (1e-15, 1e15),
    "N/s": (1e-15, 1e21),
    "N/m/s": (1e-15, 1e24),
}
"""Unit -> ends of a parameter where model.toml and law.toml give none: wider than any drive's, from
a micro-actuator's nN and nm/s to a press's MN, since a law's values are some decades around its."""
_ROTARY = {"kg": "kg.m2", "m": "rad", "mm": "mrad", "um": "urad", "N": "N.m", "N2": "N2.m2"}
_OF_LINEAR = re.compile(r"\b(kg|[mu]?m|N2?)\b")
DISPLAY: dict[str, dict[str, float]] = {
    "m": {"mm": 1e3, "um": 1e6},
    "m/s": {"mm/s": 1e3},
    "s": {"ms": 1e3},
    "N/m": {"N/um": 1e-6},
}
"""Unit -> what people read it in, and how many of those it is."""
READ_IN = {"m": "mm", "m/s": "mm/s", "s": "ms"}
"""Unit -> display unit where model.toml and law.toml give none."""
NOMINAL = {"N": 10.0, "m": 0.01, "m/s": 0.01, "m/s2": 0.1, "s": 1e-4}
"""Unit -> nominal value of a signal where model.toml and law.toml give none."""


def motion_unit(unit: str, *, rotary: bool) -> str:
    """Return a unit of a linear drive, or that of a rotary one: ``N.m.s/rad`` for ``N.s/m``."""
    return _OF_LINEAR.sub(lambda symbol: _ROTARY[symbol[0]], unit) if rotary else unit


DISPLAY |= {
    motion_unit(unit, rotary=True): {
        motion_unit(name, rotary=True): factor for name, factor in shown.items()
    }
    for unit, shown in DISPLAY.items()
    if unit != "s"
}


def parameter_range(table: Mapping[str, Any]) -> tuple[float | None, float | None]:
    """Return the ends of a parameter: its own ``min`` and ``max``, or those of its unit."""
    low, high = RANGES.get(table.get("unit", ""), (None, None))
    return table.get("min", low), table.get("max", high)


def rate_unit(unit: str) -> str:
    """Return the unit of a derivative by time."""
    exponents = {"s": 0, **UNITS[unit]}
    exponents["s"] -= 1
    wanted = {base: power for base, power in exponents.items() if power}
    return next(name for name, known in UNITS.items() if known == wanted)


def force_and_length(unit: str) -> tuple[int, int]:
    """Return the powers of force and length in a unit of ``UNITS``: (1, -1) for N/m and for kg."""
    base = UNITS[unit]
    mass = int(base.get("kg", 0))
    return mass, int(base.get("m", 0)) - mass
