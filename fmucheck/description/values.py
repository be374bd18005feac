"""Numbers and words as XML writes them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

FLOATS = {"Real": None, "Float64": None, "Float32": None}
RANGES = {
    "Integer": (-(2**31), 2**31 - 1),
    "Enumeration": (-(2**63), 2**63 - 1),
    **{f"Int{n}": (-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
    **{f"UInt{n}": (0, 2**n - 1) for n in (8, 16, 32, 64)},
}
"""Smallest and largest value of each integer type."""

Number = float | int
_FLOAT = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")  # linear: one way to match
_WORDS = {"INF": math.inf, "+INF": math.inf, "-INF": -math.inf, "NaN": math.nan}


def is_number(kind: str) -> bool:
    """Tell whether a variable of this type is compared, bounded and varied as a number."""
    return kind in FLOATS or kind in RANGES


def number(text: str | None, kind: str = "Float64") -> Number | None:
    """Return a number written for a type, or ``None`` when it is none."""
    if text is None:
        return None
    word = text.strip()
    if kind in RANGES:
        return int(word) if re.fullmatch(r"[+-]?\d{1,30}", word) else None
    if word in _WORDS:
        return _WORDS[word]
    return float(word) if _FLOAT.fullmatch(word) else None


def boolean(text: str | None) -> bool:
    """Return whether an attribute says true."""
    return (text or "").strip() in ("true", "1")


def whole(text: str | None) -> int | None:
    """Return a value reference or an index; ``None`` when it is none."""
    word = (text or "").strip()
    return int(word) if re.fullmatch(r"\d{1,20}", word) else None


def listed(names: Iterable[str], most: int = 5) -> str:
    """Return names as text, the first few of many."""
    every = list(names)
    more = f" and {len(every) - most} more" if len(every) > most else ""
    return ", ".join(every[:most]) + more
