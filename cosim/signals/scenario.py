"""What happens to signals: replaced, offset, noisy, stuck. Prepared as tables, run in C."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stickslip.cosim.errors import SignalError
from stickslip.cosim.signals.signals import Array, Input, Span, ends_of, sampled, shifted


@dataclass(frozen=True)
class Disturbance:
    """What happens to one signal: value = keep * value + add at the n points in time of a run.

    Where ``keep`` is NaN the signal sticks: value = that of the last point at which it was free +
    add. ``ends`` is what ``add`` is at the end of the step before each point.
    """

    keep: Array
    add: Array
    ends: Array

    def at_points(self, values: Array) -> Array:
        """Return a signal, (n,), as it is changed at the points in time."""
        stuck, held = np.isnan(self.keep), self._held(values)
        result: Array = np.where(stuck, held + self.add, self.keep * values + self.add)
        return result

    def at_ends(self, ends: Array, values: Array) -> Array:
        """Return a signal as it is changed at the ends of the steps before the points, (n,)."""
        keep, held = shifted(self.keep), shifted(self._held(values))
        result: Array = np.where(np.isnan(keep), held, keep * ends) + self.ends
        return result

    def in_unit(self, factor: float, offset: float) -> Disturbance:
        """Return what happens to x where this happens to factor * x + offset."""
        keep = np.where(np.isnan(self.keep), 1.0, self.keep)
        return Disturbance(
            self.keep,
            (keep * offset + self.add - offset) / factor,
            (shifted(keep) * offset + self.ends - offset) / factor,
        )

    def _held(self, values: Array) -> Array:
        """Return the value that each point has if the signal sticks there."""
        stuck = np.isnan(self.keep)
        free = np.where(stuck, values, self.keep * values + self.add)
        stuck[0] = False  # the first point follows no step
        held: Array = free[np.maximum.accumulate(np.where(stuck, 0, np.arange(len(values))))]
        return held


Tables = Mapping[str, Disturbance]


@dataclass(frozen=True)
class _Noise:
    deviation: float
    seed: int

    def sample(self, t: Array) -> Array:
        return self.deviation * np.random.default_rng(self.seed).standard_normal(len(t))


@dataclass(frozen=True)
class Event(Span):
    """What is added to a signal; with ``keep`` in place of what was done to it so far."""

    name: str
    value: Input
    keep: float | None = None

    def apply(self, time: Array, table: Disturbance) -> None:
        """Change what happens at the times (n,) in s."""
        here = self.covers(time)
        ends = shifted(here)
        values = np.broadcast_to(sampled(self.name, self.value, time), time.shape)
        if self.keep is not None:
            table.keep[here], table.add[here], table.ends[ends] = self.keep, 0.0, 0.0
        table.add[here] += values[here]
        table.ends[ends] += ends_of(self.value, values, time)[ends]


@dataclass(frozen=True)
class Scenario:
    """What happens to outputs of components and exposed inputs on their way, and to parameters.

    Each method returns a new scenario with one thing more. On one name they act in this order. A
    span holds from ``begin`` up to, not including, ``end`` (s). What is recorded is what the
    receivers see. A connection can be named by the input at its end, too, where its source feeds
    nothing else. It acts at communication points, whatever the coupling. Inputs
    that do not occur in it jump between these points as they would without it.

    Parameters must be tunable; they change at a point in time, before the step from there, and
    where an FMU knows events, by one.

    >>> dropout = Scenario().stick("drive.x_enc", begin=1.0, end=1.1).set("v_cmd", 0.0, at=2.0)
    """

    events: tuple[Event, ...] = ()

    def set(self, name: str, value: float, at: float) -> Scenario:
        """Give a signal or tunable parameter a value from a time on."""
        return self.override(name, value, at)

    def override(
        self, name: str, value: Input, begin: float = -math.inf, end: float = math.inf
    ) -> Scenario:
        """Let another signal take the place of one: a number, Signal, function or array."""
        return self._with(Event(begin, end, name, value, keep=0.0))

    def offset(
        self, name: str, value: Input, begin: float = -math.inf, end: float = math.inf
    ) -> Scenario:
        """Add a number, Signal, function or array to a signal, in its unit."""
        return self._with(Event(begin, end, name, value))

    def reset(self, name: str, at: float) -> Scenario:
        """End what the methods called before this one do to a signal or parameter."""
        return self._with(Event(at, math.inf, name, 0.0, keep=1.0))

    def add_noise(
        self,
        name: str,
        deviation: float,
        seed: int,
        begin: float = -math.inf,
        end: float = math.inf,
    ) -> Scenario:
        """Add white Gaussian noise of a standard deviation, in the unit of the signal."""
        if not 0.0 <= deviation < math.inf or not isinstance(seed, int) or seed < 0:
            raise SignalError(
                f"noise on {name}: deviation {deviation} and seed {seed!r}, expected a finite"
                " deviation and a whole seed, each 0 or more"
            )
        return self._with(Event(begin, end, name, _Noise(deviation, seed)))

    def stick(self, name: str, begin: float, end: float = math.inf) -> Scenario:
        """Let a signal keep the value that it had a step before ``begin``."""
        return self._with(Event(begin, end, name, 0.0, keep=math.nan))

    def tables(self, time: Array) -> Tables:
        """Return what happens at the times (n,) in s; SignalError where it is not finite."""
        tables: dict[str, Disturbance] = {}
        n = len(time)
        for event in self.events:
            fresh = Disturbance(np.ones(n), np.zeros(n), np.zeros(n))
            table = tables.setdefault(event.name, fresh)
            with np.errstate(over="ignore"):
                event.apply(time, table)
            if not np.isfinite([table.add, table.ends]).all():
                raise SignalError(f"scenario: {event.name} would not be finite")
        return tables

    def _with(self, event: Event) -> Scenario:
        return replace(self, events=(*self.events, event))
