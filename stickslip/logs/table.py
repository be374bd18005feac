"""The table that a log's file holds, before its columns have roles; points in time as seconds."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import RecordingError, UsageError
from stickslip.fmi.messages import suggestion
from stickslip.logs.description import Product
from stickslip.logs.recording import Finding
from stickslip.logs.units import unit_named
from stickslip.servo.measurement import Array


@dataclass(frozen=True, eq=False)
class LogTable:
    """Columns by name, as they were read."""

    path: str  # of the file, for messages
    names: tuple[str, ...]  # of all columns, in the file's order
    numbers: Mapping[str, Array]  # (n,) by name; nan where a field is empty
    # (n,) by name, of columns that hold no numbers
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)  # by name, where the file states one
    faults: Mapping[str, str] = field(default_factory=dict)  # by name, why a column cannot be used
    scalars: Mapping[str, float] = field(default_factory=dict)  # single numbers beside the columns
    rows: NDArray[np.intp] | None = None  # (n,) line or row of each value; None counts from 1
    headed: bool = True  # whether the file itself names its columns
    findings: tuple[Finding, ...] = ()  # of reading

    def row(self, k: int) -> int:
        """Return the number in the file of the k-th value."""
        return k + 1 if self.rows is None else int(self.rows[k])

    def part(self, rows: NDArray[np.intp]) -> "LogTable":
        """Return a table without columns that has some rows (k,) of this one."""
        numbers = rows + 1 if self.rows is None else self.rows[rows]
        return LogTable(self.path, self.names, {}, scalars=self.scalars, rows=numbers)

    def find(self, key: str | int, role: str) -> str:
        """Return the name of the column with a name or a number from 1; raise RecordingError."""
        if isinstance(key, str) and key in self.names:
            return key
        if isinstance(key, int) or key.isdecimal():
            if 1 <= int(key) <= len(self.names):
                return self.names[int(key) - 1]
            raise RecordingError(
                f"{self.path}: {role}: no column {key}, there are {len(self.names)}"
            )
        alike = [name for name in self.names if name.lower() == key.lower()]
        if len(alike) == 1:
            return alike[0]
        if alike:
            raise RecordingError(f"{self.path}: {role}: which column, {' or '.join(alike)}?")
        raise RecordingError(f"{self.path}: {role}: no column '{key}'{suggestion(key, self.names)}")

    def value(self, product: Product, what: str) -> float:
        """Return the value of a product of numbers and scalars of the file; raise UsageError."""
        value = 1.0
        for factor in str(product).split("*"):
            name = factor.strip()
            try:
                value *= self.scalars[name] if name in self.scalars else float(name)
            except ValueError:
                hint = suggestion(name, self.scalars) if self.scalars else ""
                raise UsageError(
                    f"{what} = {product}: expected a number in SI units, or a scalar of the file, "
                    f"got '{name}'{hint}"
                ) from None
        if not math.isfinite(value):
            raise UsageError(f"{what} = {product}: expected a finite number, got {value}")
        return value

    def column(self, name: str) -> Array:
        """Return the numbers (n,) of a column; raise RecordingError when it holds none."""
        if name in self.faults:
            raise RecordingError(f"{self.path}: column '{name}': {self.faults[name]}")
        if name in self.texts:
            raise RecordingError(
                f"{self.path}: column '{name}', row {self.row(0)}: expected a number, got "
                f"'{self.texts[name][0][:40]}'"
            )
        return self.numbers[name]


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
    """Return exact seconds since the first of counts of 100 ns since 1601, else None."""
    if not (texts and all(text.isdecimal() for text in texts) and float(texts[0]) > FILETIME):
        return None
    first = int(texts[0])
    return np.array([(int(text) - first) * 1e-7 for text in texts])


def with_joined_times(table: LogTable) -> LogTable:
    """Return a table with one time for two such as ``stamp.sec`` and ``stamp.nanosec``."""
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
