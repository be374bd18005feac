"""Signals over time for the exposed inputs of a system."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim.errors import SignalError
from stickslip.cosim.signals.csv_columns import read_columns
from stickslip.fmi.messages import printable


def slack(t: Any, step: float) -> Any:
    """Return how far from times t (s) another may lie that is meant to be the same, in s.

    A millionth of the step of the run, or the next number that a computer has: at large times, such
    as those of a clock that counts from 1970, that is more.
    """
    return 1e-6 * step + np.spacing(np.abs(t))


Array = NDArray[np.float64]


class Signal(Protocol):
    """A function of time."""

    def sample(self, t: Array) -> Array:
        """Return the values (n,) at the times t (n,) in s."""


Input = Signal | Callable[[Any], Any] | Array | float


@dataclass(frozen=True)
class SineSweep:
    """A sine whose frequency and amplitude run linearly from one value to another; 0 outside.

    Attributes
    ----------
    frequency : at the begin and the end, Hz
    amplitude : at the begin and the end, in the unit of the input
    duration : s
    begin : s

    Raises
    ------
    SignalError : when one is not finite, the duration not positive, or a range not two numbers
    """

    frequency: tuple[float, float]
    amplitude: tuple[float, float]
    duration: float
    begin: float = 0.0

    def __post_init__(self) -> None:
        numbers = (self.frequency, self.amplitude, (self.duration, self.begin))
        if _numbers(self, *numbers).shape != (3, 2) or not self.duration > 0.0:
            what = "expected two frequencies, two amplitudes and a positive duration"
            raise SignalError(f"{self}: {what}")

    def sample(self, t: Array) -> Array:
        """Return the values (n,) at the times t (n,) in s."""
        (f0, f1), (a0, a1) = self.frequency, self.amplitude
        x = t - self.begin
        share = x / self.duration
        cycles = (f0 + 0.5 * (f1 - f0) * share) * x
        values = (a0 + (a1 - a0) * share) * np.sin(2 * math.pi * cycles)
        return np.where((share >= 0) & (share <= 1), values, 0.0)


@dataclass(frozen=True)
class Trapezoid:
    """Up to a height, down through zero to minus the height, and back to zero, with equal ramps.

    Attributes
    ----------
    height : of the plateaus, in the unit of the input
    slope : of the ramps, in the unit of the input per s; positive
    plateau : how long each of the two lasts, s
    begin : s

    Raises
    ------
    SignalError : when one is not finite, the slope not positive, or the plateau negative
    """

    height: float
    slope: float
    plateau: float
    begin: float = 0.0

    def __post_init__(self) -> None:
        _numbers(self, self.height, self.slope, self.plateau, self.begin)
        if not (self.slope > 0.0 and self.plateau >= 0.0):
            raise SignalError(f"{self}: expected a slope above 0 and a plateau of 0 or more")

    def sample(self, t: Array) -> Array:
        """Return the values (n,) at the times t (n,) in s."""
        return np.interp(t, self.corners(), np.array([0, 1, 1, -1, -1, 0]) * self.height)

    def corners(self) -> Array:
        """Return the times (6,) in s where ramps and plateaus meet."""
        ramp = abs(self.height) / self.slope
        return np.cumsum([self.begin, ramp, self.plateau, 2 * ramp, self.plateau, ramp])


@dataclass(frozen=True, eq=False)
class Table:
    """Values between which is drawn a straight line; outside, the first and last value hold.

    A time that occurs twice makes a jump: from then on the later value holds. An input that is
    discrete (integers, Boolean) has no lines: each value holds until the next. A jump between two
    points in time of a run makes it communicate there, too, where all FMUs allow that.

    Attributes
    ----------
    time : (n,) s, never falling
    values : (n,) in the unit of the input
    held : whether each value holds until the next time instead
    """

    time: Array
    values: Array
    held: bool = False

    def __post_init__(self) -> None:
        for name in ("time", "values"):
            try:
                values = np.array(getattr(self, name), dtype=np.float64)
            except (TypeError, ValueError):
                shown = str(getattr(self, name))[:80]
                raise SignalError(f"{name} of a table: expected numbers, got {shown}") from None
            object.__setattr__(self, name, values)
        t, x = self.time, self.values
        if t.ndim != 1 or t.shape != x.shape or not len(t):
            what = f"time has the shape {t.shape}, values {x.shape}"
            raise SignalError(f"{what}; expected (n,) twice")
        if not (np.isfinite(t).all() and np.isfinite(x).all()):
            raise SignalError("a table holds a time or value that is not finite")
        if (falling := np.flatnonzero(np.diff(t) < 0)).size:
            raise SignalError(f"time falls from {t[falling[0]]} to {t[falling[0] + 1]} s")

    @classmethod
    def all_from_csv(cls, path: str | os.PathLike[str]) -> dict[str, Self]:
        """Read every column, by name, of a CSV file with ``time`` (s), or raise SignalError."""
        columns = read_columns(Path(path))
        time = columns.pop("time")
        return {name: cls(time, column) for name, column in columns.items()}

    def sample(self, t: Array) -> Array:
        """Return the values (n,) at the times t (n,) in s."""
        if self.held:
            return self.hold(t)
        if len(self.time) == 1:
            return np.full(np.shape(t), self.values[0])
        right = np.clip(np.searchsorted(self.time, t), 1, len(self.time) - 1)
        t0, t1 = self.time[right - 1], self.time[right]
        share = np.zeros(np.shape(t))  # of the left value; in this form FMPy has the same bits
        np.divide(t1 - t, t1 - t0, out=share, where=t1 > t0)
        share = np.clip(share, 0.0, 1.0)
        line = share * self.values[right - 1] + (1 - share) * self.values[right]
        last = np.searchsorted(self.time, t + _slack_of(t), side="right") - 1
        jumps = (self.time[last] > t) & (self.time[np.maximum(last - 1, 0)] == self.time[last])
        return np.where((self.time[last] == t) | jumps, self.values[last], line)

    def hold(self, t: Array) -> Array:
        """Return the values (n,) at the times t (n,) in s where each holds until the next."""
        last = np.searchsorted(self.time, t + _slack_of(t), side="right") - 1
        return self.values[np.maximum(last, 0)]

    def before(self, t: Array) -> Array:
        """Return the values (n,) just before the times t (n,) in s, where they may jump."""
        mirrored = Table(-self.time[::-1], self.values[::-1])
        return mirrored.sample(-t[::-1])[::-1]

    def jumps(self, *, discrete: bool) -> Array:
        """Return the times (s) at which the signal jumps, as a discrete input or another."""
        jumps = np.diff(self.time) == 0
        if discrete or self.held:
            jumps |= np.diff(self.values) != 0
        return np.unique(self.time[1:][jumps])


def _numbers(signal: object, *given: Any) -> Array:
    """Return what a signal is made of as an array; all of it has to be finite."""
    try:
        numbers = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if not np.isfinite(numbers).all():
        raise SignalError(f"{signal}: expected finite numbers")
    return numbers


def _slack_of(t: Array) -> Array:
    steps = np.abs(np.diff(np.ravel(t)))
    near: Array = slack(t, float(steps.min()) if steps.size else 0.0)
    return near


def ends_of(signal: Input, values: Array, time: Array) -> Array:
    """Return a signal, whose values at the points in time are given, just before them."""
    if not isinstance(signal, Table):
        return values
    return shifted(values) if signal.held else signal.before(time)


def shifted(values: NDArray[Any]) -> NDArray[Any]:
    """Return for each point the value of the one before, for the first its own."""
    return np.append(values[:1], values[:-1])


def sampled(name: str, signal: Input, time: Array) -> Array:
    """Return an input over time, (n,) or a single value for all times, or raise SignalError."""
    if hasattr(signal, "columns"):
        raise SignalError(
            f"input {name!r}: expected a signal, a series, a function, an array or a number, got a"
            f" {type(signal).__name__}; give the data frame itself as inputs"
        )
    if hasattr(signal, "sample"):
        signal = signal.sample(time)
    elif callable(signal):
        signal = _evaluated(name, signal, time)
    if hasattr(signal, "magnitude") and hasattr(signal, "units"):
        what = f"got a quantity in {signal.units}; give the magnitude of quantity.to(unit)"
        raise SignalError(f"input {name!r}: expected numbers in the unit of the input, {what}")
    wrong = f"input {name!r}: expected numbers, got "  # a run of numbers formats none of them
    kind = getattr(getattr(signal, "dtype", None), "kind", "")
    if isinstance(signal, str | bytes | complex) or kind == "c":
        raise SignalError(wrong + printable(repr(signal), 80))
    try:
        plain: Any = signal
        values = np.asarray(np.ma.filled(plain, np.nan), dtype=np.float64)
    except (TypeError, ValueError):
        raise SignalError(wrong + printable(repr(signal), 80)) from None
    if values.ndim and values.shape != time.shape:
        what = f"expected {time.shape}: one value for each point in time, the last included"
        raise SignalError(f"input {name!r} has the shape {values.shape}, {what}")
    if not (finite := np.isfinite(values)).all():
        when = time[np.argmin(finite)] if values.ndim else time[0]
        raise SignalError(f"input {name!r} is not finite at t = {when:.9g} s")
    return values


def _evaluated(name: str, function: Callable[[Any], Any], time: Array) -> Any:
    """Return a function at the times (n,) in s: of all at once, else of one after the other.

    Only an array of n values is taken for those of all times. A single value may be of a function
    that ignores the time, and of one that looks up, or averages over, what it takes for one time.
    """
    try:
        values = function(time.copy())
        if np.shape(values) == time.shape or hasattr(values, "magnitude"):
            return values
        whole = f"returned the shape {np.shape(values)}"
    except Exception as fault:  # noqa: BLE001 - a function of one time may raise any
        whole = _told(fault)
    found = []
    for t in time.tolist():
        try:
            value = function(t)
        except Exception as fault:
            also = "" if whole == _told(fault) else f"; for an array of all times it {whole}"
            what = f"at t = {t:.9g} s the function {_told(fault)}{also}"
            raise SignalError(f"input {name!r}: {what}") from fault
        found.append(value if isinstance(value, (float, int)) else _number(name, t, value))
    return np.array(found, dtype=np.float64)


def _number(name: str, t: float, value: Any) -> float:
    """Return what a function returned at t [s], alone or in a list or array, as a number."""
    try:
        array = isinstance(value, list | tuple | np.ndarray)
        return float(np.asarray(value).item() if array else value)
    except (TypeError, ValueError):
        got = printable(repr(value), 80)
        what = f"at t = {t:.9g} s the function returned {got}, expected a number"
        raise SignalError(f"input {name!r}: {what}") from None


def _told(fault: Exception) -> str:
    return printable(f"raised {type(fault).__name__}: {fault}")
