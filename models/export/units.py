"""The units that models use, as exponents of SI base units."""

from __future__ import annotations

UNITS: dict[str, dict[str, int]] = {
    "1": {},
    "kg": {"kg": 1},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "N.s/m": {"kg": 1, "s": -1},
    "s": {"s": 1},
}


DISPLAY = {
    "m": {"mm": 1e3, "um": 1e6},
    "m/s": {"mm/s": 1e3},
    "s": {"ms": 1e3},
    "N/m": {"N/um": 1e-6},
}
"""Unit -> what people read it in, and how many of those it is."""


def rate_unit(unit: str) -> str:
    """Return the unit of a derivative by time."""
    exponents = {"s": 0, **UNITS[unit]}
    exponents["s"] -= 1
    wanted = {base: power for base, power in exponents.items() if power}
    return next(name for name, known in UNITS.items() if known == wanted)
