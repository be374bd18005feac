"""FMUs of candidates, their runs, and what closes them."""

from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from functools import cached_property
from pathlib import Path
from typing import Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from stickslip import cosim
from stickslip.catalog.parameters import ParameterSpace, Values
from stickslip.cosim.signals.signals import Input
from stickslip.fmi.process import Threads, temporary_folder
from stickslip.servo.lanes import FEWEST, Lanes, Run, lanes_of
from stickslip.servo.measurement import Array
from stickslip.servo.systems import build_fmus
from stickslip.thresholds import loop_fit


class Closing:
    """Closes itself and what it holds when a ``with`` block ends."""

    held: "Sequence[Closing]" = ()

    def close(self) -> None:
        """Free the FMUs."""
        for one in self.held:
            one.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@contextmanager
def candidate_fmus(law: str = "lugre") -> Iterator[Path]:
    """Build them with a friction law into a folder that is deleted at the end of the block.

    They contain nothing of the drive that made a recording, not even which of its extras are on.
    """
    with temporary_folder() as folder:
        build_fmus(folder, {"law": law}, law, ("compensator", "drive", "velocity_controller"))
        yield folder


RECENT = 12  # number of runs whose results a criterion keeps: those of one Jacobian

T = TypeVar("T")
R = TypeVar("R")
K = TypeVar("K")
Outcome = cosim.Result | cosim.SimulationError  # of a run


class Runs(Closing):
    """Runs of a system, which leave the interpreter lock, in threads that change no result."""

    def __init__(self, specification: cosim.Specification, workers: int = 1) -> None:
        self._specification = specification
        self.workers = workers
        self._threads = Threads(workers) if workers > 1 else None
        self._all: list[cosim.Simulation] = []  # made where lanes do not do
        self._idle: list[cosim.Simulation] = []

    def run(
        self,
        parameters: Mapping[str, object],
        inputs: Mapping[str, Input],
        until: float | None = None,
    ) -> cosim.Result:
        """Run once, see ``cosim.Simulation.run``."""
        try:
            simulation = self._idle.pop()
        except IndexError:
            simulation = self._specification.prepare()
            self._all.append(simulation)
        try:
            return simulation.run(parameters, inputs, until=until)
        finally:
            self._idle.append(simulation)

    def batch(self, runs: Sequence[Run], *, in_lanes: bool = True) -> list[Outcome]:
        """Run in lanes where that is possible; return the results of ``run``, or what it raises."""
        lanes = self._lanes if in_lanes and len(runs) >= FEWEST else None
        found = lanes.run(runs, self.each) if lanes else [None] * len(runs)
        missing = [k for k, one in enumerate(found) if one is None]
        tried = zip(missing, self.each(self._tried, [runs[k] for k in missing]), strict=True)
        left = dict(tried)
        return [left[k] if one is None else one for k, one in enumerate(found)]

    def results(self, runs: Sequence[Run]) -> list[cosim.Result]:
        """Do what ``batch`` does, and raise what the first run that failed has raised."""
        return [result_of(outcome) for outcome in self.batch(runs)]

    @cached_property
    def _lanes(self) -> Lanes | None:
        return lanes_of(self._specification)

    def _tried(self, run: Run) -> Outcome:
        try:
            return self.run(*run)
        except cosim.SimulationError as error:
            return error

    def each(self, function: Callable[[T], R], items: Sequence[T]) -> list[R]:
        """Apply a function that runs this system to every item, several at a time."""
        if self._threads is None or len(items) < 2:
            return list(map(function, items))
        return self._threads.each(function, items)

    def close(self) -> None:
        """Free the FMUs."""
        if self._threads:
            self._threads.shutdown(cancel_futures=True)
        for simulation in self._all:
            simulation.close()


Rows = slice | NDArray[np.intp]
"""Which rows count."""


def together(logs: Sequence[slice]) -> Rows:
    """Return the rows of several logs; of a single one they need no copy."""
    return logs[0] if len(logs) == 1 else np.concatenate([np.r_[one] for one in logs])


class Criterion(Closing):
    """Compares the values of a parameter space with a recording, by runs of FMUs."""

    name: str  # display name
    every: int  # the samples of which a search for the minimum needs one; the others follow it
    space: ParameterSpace  # the parameters and their coordinates

    @abstractmethod
    def residual(self, values: Values) -> Array:
        """Return the difference that the values leave (n,)."""

    def run(self, points: Iterable[Values]) -> None:
        """Make the runs of several points side by side, so that their residuals need none."""

    def map(self, points: Iterable[Values]) -> list[Array]:
        """Return the residuals of several points, whose runs are made side by side."""
        points = list(points)
        self.run(points)
        return [self.residual(values) for values in points]

    def over(self, space: ParameterSpace) -> Self:
        """Return the same criterion over another space; it shares the FMUs."""
        other = copy(self)
        other.space = space
        return other


class Recent(Generic[K, R]):
    """What runs gave, by what they were made with; the latest are kept."""

    def __init__(self, make: Callable[[Sequence[K]], Iterable[R]]) -> None:
        self._make = make  # side by side
        self._kept: dict[K, R] = {}

    def __call__(self, keys: Sequence[K]) -> list[R]:
        """Return what belongs to some keys; make what is not kept."""
        kept = self._kept  # replaced as a whole, so that threads may ask at once
        found = {key: kept[key] for key in dict.fromkeys(keys) if key in kept}
        left = [key for key in dict.fromkeys(keys) if key not in found]
        if not left:
            return [found[key] for key in keys]
        found |= zip(left, self._make(left), strict=True)
        latest = {key: one for key, one in kept.items() if key not in found} | found
        self._kept = dict([*latest.items()][-max(RECENT, len(found)) :])
        return [found[key] for key in keys]


def result_of(outcome: Outcome) -> cosim.Result:
    """Return the result of a run, or raise what it has raised."""
    if isinstance(outcome, cosim.SimulationError):
        raise outcome
    return outcome


class Diverged(cosim.SimulationError):
    """A simulated drive ran away from its command."""


def require_bounded(v: Array, speed: float) -> None:
    """Raise Diverged where a velocity (n,) is not finite, or far beyond the commanded one [m/s]."""
    peak = float(np.max(np.abs(v)))
    if not peak <= loop_fit.RUNS_AWAY * speed:
        raise Diverged(
            f"the simulated loop runs away: its velocity exceeds {loop_fit.RUNS_AWAY:g} times the "
            "largest commanded one; expected a loop that is stable with these gains; check their "
            "units and signs, the delay and the mass"
        )


def bounded(outcome: Outcome, name: str, speed: float) -> Outcome:
    """Return the outcome of a run, Diverged where its velocity has run away."""
    try:
        if not isinstance(outcome, cosim.SimulationError):
            require_bounded(outcome[name], speed)
    except Diverged as error:
        return error
    return outcome
