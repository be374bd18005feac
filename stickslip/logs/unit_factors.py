"""Ratios near a factor between units, which indicate a wrong unit."""

from __future__ import annotations

import math

from stickslip.thresholds import log_unit

_TURN = 2 * math.pi
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
