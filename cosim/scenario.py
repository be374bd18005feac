"""What happens to signals during a run: replaced, noisy, stuck. Prepared as tables, run in C."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from cosim.errors import SignalError
from cosim.signals import Array, Input, sampled
from cosim.span import Span

Tables = Mapping[str, tuple[Array, Array]]
"""Name -> keep and add, each (n,), of value = keep * value + add; keep is NaN where it sticks."""


class Event(Protocol):
    """One thing that happens to a signal."""

    def apply(self, time: Array, keep: Array, add: Array) -> None:
        """Change value = keep * value + add, both (n,), where it happens; keep is NaN if stuck."""


@dataclass(frozen=True)
class _Override(Span):
    name: str
    value: Input

    def apply(self, time: Array, keep: Array, add: Array) -> None:
        here = self.covers(time)
        values = np.broadcast_to(sampled(self.name, self.value, time), time.shape)
        keep[here], add[here] = 0.0, values[here]


@dataclass(frozen=True)
class _Noise(Span):
    deviation: float
    seed: int

    def apply(self, time: Array, keep: Array, add: Array) -> None:  # noqa: ARG002 - one face
        here = self.covers(time)
        noise = np.random.default_rng(self.seed).standard_normal(len(time))
        add[here] += self.deviation * noise[here]


@dataclass(frozen=True)
class _Stuck(Span):
    def apply(self, time: Array, keep: Array, add: Array) -> None:  # noqa: ARG002 - one face
        keep[self.covers(time)] = math.nan


@dataclass(frozen=True)
class Scenario:
    """What happens to outputs of components and exposed inputs on their way, and to parameters.

    Each method returns a new scenario with one thing more. On one name they act in this order. A
    span holds from ``begin`` up to, not including, ``end`` (s). What is recorded is what the
    receivers see. It acts at communication points, whatever the coupling. Parameters must be
    tunable; they change at a point in time, before the step from there, and where an FMU knows
    events, by one.

    >>> dropout = Scenario().stick("drive.x_enc", begin=1.0, end=1.1).set("v_cmd", 0.0, at=2.0)
    """

    events: tuple[tuple[str, Event], ...] = ()

    def set(self, name: str, value: float, at: float) -> Scenario:
        """Give a signal or tunable parameter a value from a time on."""
        return self.override(name, value, at)

    def override(
        self, name: str, value: Input, begin: float = -math.inf, end: float = math.inf
    ) -> Scenario:
        """Let another signal take the place of one: a number, Signal, function or array."""
        return self._with(name, _Override(begin, end, name, value))

    def add_noise(
        self,
        name: str,
        deviation: float,
        seed: int,
        begin: float = -math.inf,
        end: float = math.inf,
    ) -> Scenario:
        """Add white Gaussian noise of a standard deviation, in the unit of the signal."""
        return self._with(name, _Noise(begin, end, deviation, seed))

    def stick(self, name: str, begin: float, end: float = math.inf) -> Scenario:
        """Let a signal keep the value that it had a step before ``begin``."""
        return self._with(name, _Stuck(begin, end))

    def tables(self, time: Array) -> Tables:
        """Return what happens at the times (n,) in s.

        Raises
        ------
        SignalError
            When a value is not finite.
        """
        tables: dict[str, tuple[Array, Array]] = {}
        for name, event in self.events:
            keep, add = tables.setdefault(name, (np.ones(len(time)), np.zeros(len(time))))
            event.apply(time, keep, add)
            if not np.isfinite(add).all():
                raise SignalError(f"scenario: {name} would not be finite")
        return tables

    def _with(self, name: str, event: Event) -> Scenario:
        return replace(self, events=(*self.events, (name, event)))
