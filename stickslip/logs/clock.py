"""Points in time as seconds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stickslip.logs.table import LogTable
from stickslip.logs.units import unit_named
from stickslip.servo.measurement import Array

_DAY = re.compile(r"\d{4}-\d\d?-\d\d?[T ]\d|\d\d?[./]\d\d?[./]\d{4},? +\d|\d\d?:\d\d")
FILETIME = 1e16  # larger times count 100 ns, as Windows does


def is_clock(text: str) -> bool:
    """Whether a text looks like a point in time, with or without a date."""
    return bool(_DAY.match(text))


def clock_seconds(texts: Sequence[str]) -> Array:
    """Return seconds (n,) since the first of points in time such as 2026-01-31T10:00:00.125.

    Dates are ISO 8601 or day.month.year, fractions have a point or a comma. A time without a date
    that falls back by more than half a day belongs to the next one. Raises ValueError when a text
    is not a point in time, or lies beyond 2262.
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


def with_joined_times(table: LogTable) -> LogTable:
    """Return a table with one column of time for each two that hold whole seconds and the rest.

    Such are ``stamp.sec`` and ``stamp.nanosec``, and ``tv_sec`` and ``tv_usec``.
    """
    numbers, units = dict(table.numbers), dict(table.units)
    names = list(table.names)
    seconds: dict[str, str] = {}
    for name in table.names:
        last = re.split(r"[\W_]", name)[-1]
        stem, unit = name.removesuffix(last), unit_named(last)
        if unit is None or unit.quantity != "time" or name not in table.numbers:
            continue
        if unit.factor == 1:
            seconds[stem] = name
        elif (whole := seconds.get(stem)) and _is_rest(numbers[whole], numbers[name], unit.factor):
            joined = f"{whole} and {name} as time"
            begin = numbers[whole] - numbers[whole][:1]
            numbers[joined], units[joined] = begin + numbers[name] * unit.factor, "s"
            names[names.index(whole)] = joined
            names.remove(name)
    return replace(table, names=tuple(names), numbers=numbers, units=units)


def _is_rest(seconds: Array, rest: Array, unit: float) -> bool:
    """Whether numbers (n,) lie within one second, beside whole seconds."""
    rest, seconds = rest[np.isfinite(rest)], seconds[np.isfinite(seconds)]
    return bool(np.all((rest >= 0) & (rest * unit < 1)) and np.all(seconds % 1 == 0))
