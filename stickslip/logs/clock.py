"""Points in time as seconds."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from stickslip.servo.measurement import Array

_DAY = re.compile(r"\d{4}-\d\d?-\d\d?[T ]\d|\d\d?[./]\d\d?[./]\d{4},? +\d|\d\d?:\d\d")
FILETIME = 1e16
"""Larger times count 100 ns, as Windows does."""


def is_clock(text: str) -> bool:
    """Whether a text looks like a point in time, with or without a date."""
    return bool(_DAY.match(text))


def clock_seconds(texts: Sequence[str]) -> Array:
    """Return seconds (n,) since the first of points in time such as 2026-01-31T10:00:00.125.

    Dates are ISO 8601 or day.month.year, fractions have a point or a comma. A time without a date
    that falls back by more than half a day belongs to the next one.

    Raises
    ------
    ValueError
        When a text is not a point in time, or lies beyond 2262.
    """
    import pandas as pd  # late, for those who start quickly

    plain = [text.replace(",", ".") for text in texts]
    if ":" in plain[0][:3]:
        seconds = pd.to_timedelta(plain).total_seconds().to_numpy()
        days = np.cumsum(np.diff(seconds, prepend=seconds[0]) < -43200.0)
        return np.asarray(seconds + 86400.0 * days - seconds[0], dtype=np.float64)
    if re.match(r"\d{4}-", plain[0]):
        times = pd.to_datetime(plain, format="ISO8601", utc=True)
    else:
        dotted = [re.sub(r"^(\d+)[./](\d+)[./](\d+)\.? +", r"\1.\2.\3 ", text) for text in plain]
        times = pd.to_datetime(dotted, format="mixed", dayfirst=True, utc=True)
    return np.asarray((times - times[0]).total_seconds(), dtype=np.float64)


def filetime_seconds(texts: Sequence[str]) -> Array | None:
    """Return seconds (n,) since the first of counts of 100 ns since 1601, None for other numbers.

    Doubles would round such counts to 1.6 us.
    """
    if not (texts and all(text.isdecimal() for text in texts) and float(texts[0]) > FILETIME):
        return None
    first = int(texts[0])
    return np.array([(int(text) - first) * 1e-7 for text in texts])
