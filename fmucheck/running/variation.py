"""What a variable starts with, and other values that it should take."""

from __future__ import annotations

import math
from typing import Any

from stickslip.fmucheck.description.model import Variable
from stickslip.fmucheck.description.units import items_of
from stickslip.fmucheck.description.values import FLOATS, RANGES, number


def start_of(v: Variable) -> tuple[Any, ...] | None:
    """Return a variable's start values in its own type, ``None`` when it has none."""
    if v.start is None:
        return None
    if v.kind == "String":
        return tuple(text.encode() for text in v.start)
    if v.kind == "Binary":
        return tuple(bytes.fromhex(text) for text in v.start)
    if v.kind == "Boolean":
        return tuple(text.strip() in ("true", "1") for text in v.start)
    return tuple(number(text, v.kind) for text in v.start)


def other(v: Variable, factor: float = 0.1) -> tuple[Any, ...] | None:
    """Return start values moved within the variable's range, ``None`` if they cannot be."""
    starts = start_of(v)
    if starts is None or v.kind in ("String", "Binary") or None in starts:
        return None
    return tuple(moved(v, start, factor) for start in starts)


def moved(v: Variable, value: Any, factor: float) -> Any:
    """Return a value moved by ``factor`` of the variable's size, kept within its range."""
    if v.kind == "Boolean":
        return not value if factor > 0 else value
    low, high = v.number("min"), v.number("max")
    if v.kind == "Enumeration":
        items = sorted(items_of(v)) or [value]
        return items[(items.index(value) + 1) % len(items)] if value in items else value
    if v.kind in RANGES:
        least, most = RANGES[v.kind]
        low, high = max(least, low or least), min(most, most if high is None else high)
        there = value + (1 if factor > 0 else -1)
    else:
        there = value + factor * scale(v, value)
    if low is not None and there < low:
        return (value + low) / 2 if v.kind in FLOATS else low
    if high is not None and there > high:
        return (value + high) / 2 if v.kind in FLOATS else high
    return there


def scale(v: Variable, value: float) -> float:
    """Return the usual size of a variable."""
    nominal = v.number("nominal")
    if nominal and math.isfinite(nominal):
        return abs(nominal)
    return abs(value) if value and math.isfinite(value) else 1.0
