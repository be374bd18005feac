"""Lets simulated time pass no faster than the time on the wall."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

from stickslip.cosim.errors import ExperimentError


@dataclass
class RealTimePacing:
    """Keeps step with the clock and notes where that failed.

    Attributes
    ----------
    speed : simulated s per s
    interval : of looks at the clock, simulated s; at least one step
    looks : how often it looked
    overruns : how often the simulation was late by more than an interval
    worst : the most by which it was late, s on the clock
    """

    speed: float
    interval: float = 0.01
    looks: int = 0
    overruns: int = 0
    worst: float = 0.0
    clock: Callable[[], float] = time.perf_counter
    sleep: Callable[[float], None] = time.sleep

    def __post_init__(self) -> None:
        if not (0 < self.speed < math.inf and 0 < self.interval < math.inf):
            raise ExperimentError(
                f"real time with the speed {self.speed} and the interval {self.interval} s:"
                " expected positive numbers"
            )

    @classmethod
    def of(cls, real_time: Self | float) -> Self:
        """Return pacing that has counted nothing yet, given as itself or as its speed."""
        if isinstance(real_time, RealTimePacing):
            return replace(real_time, looks=0, overruns=0, worst=0.0)
        return cls(real_time)

    def begin(self, t: float) -> None:
        """Start the clock at a simulated time (s)."""
        self._start, self._t = self.clock(), t

    def keep(self, t: float) -> None:
        """Wait until it is time for a simulated time (s)."""
        due = self._start + (t - self._t) / self.speed
        late = self.clock() - due
        self.looks += 1
        self.worst = max(self.worst, late)
        if late * self.speed > self.interval:
            self.overruns += 1
        elif late < 0:
            self.sleep(-late)
