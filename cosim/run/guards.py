"""One thread of one process is in a simulation, whose time may follow the clock on the wall."""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NoReturn, Self

from stickslip.cosim.errors import ExperimentError, SharedSimulation


class Exclusive:
    """Lets a thread in unless another is, or the process has forked and has no copy of all."""

    def __init__(self, name: str, *, outlives_fork: bool) -> None:
        self._name, self._outlives_fork = name, outlives_fork
        self._lock = threading.Lock()
        self._process = os.getpid()

    @property
    def is_ours(self) -> bool:
        """Whether this process may call the FMUs."""
        return not self._forked() or (self._outlives_fork and not self._lock.locked())

    def __enter__(self) -> None:
        if not self._outlives_fork and self._forked():
            self._refuse()
        if not self._lock.acquire(blocking=False):
            self._refuse()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def _forked(self) -> bool:
        return os.getpid() != self._process

    def _refuse(self) -> NoReturn:
        if self._forked():
            raise SharedSimulation(
                f"{self._name}: this simulation was prepared before the process was forked, and"
                " belongs to the other process; prepare another one here: simulation.spec.prepare()"
            )
        raise SharedSimulation(
            f"{self._name}: this simulation is in use; it runs in one thread at a time, and not"
            " from its own progress function; prepare another one for each thread:"
            " simulation.spec.prepare()"
        )


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
