"""The parameters of Table 2 and what they are called."""

from __future__ import annotations

from collections.abc import Mapping

UNITS = {
    "m": "kg",
    "b": "N.s/m",
    "F_s": "N",
    "F_c": "N",
    "v_s": "m/s",
    "sigma_0": "N/m",
    "sigma_1": "N.s/m",
}

_ROTARY = {
    "kg": "kg.m2",
    "N.s/m": "N.m.s/rad",
    "N": "N.m",
    "m/s": "rad/s",
    "N/m": "N.m/rad",
}


def unit_of(name: str, *, rotary: bool = False) -> str:
    """Return the unit of a parameter, for a linear or a rotary drive."""
    unit = UNITS[name]
    return _ROTARY[unit] if rotary else unit


PAPER = {
    "m": 5.557,
    "b": 6.6135,
    "F_s": 8.999,
    "F_c": 5.999,
    "v_s": 0.00055697,
    "sigma_0": 3.9162e5,
    "sigma_1": 4.4248e3,
}
"""Table 2 of the paper. It prints b in Nm/sec, which must read N s/m."""

LUGRE = ("F_s", "F_c", "v_s", "sigma_0", "sigma_1")
"""The five that the genetic algorithm learns."""

_FORCES = ("F_s", "F_c", "sigma_0", "sigma_1")


def at_share(friction: Mapping[str, float], share: float) -> dict[str, float]:
    """Return LuGre parameters whose force is a share of that of others at the same motion."""
    return {**friction, **{name: share * friction[name] for name in _FORCES}}
