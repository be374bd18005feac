"""One system that is run again and again, several candidates side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar

from stickslip import cosim
from stickslip.cosim.signals.signals import Input
from stickslip.fmi.process import Threads
from stickslip.identification.criteria.closing import Closing

RECENT = 64  # number of runs whose results a criterion keeps: some Jacobians of a fit

T = TypeVar("T")
R = TypeVar("R")


class Runs(Closing):
    """Runs of a system, in any thread. Which thread runs what changes no result.

    Parameters
    ----------
    specification : the system
    workers : threads that ``each`` uses; a run leaves the interpreter lock
    """

    def __init__(self, specification: cosim.Specification, workers: int = 1) -> None:
        self._specification = specification
        self._threads = Threads(workers) if workers > 1 else None
        self._all = [specification.prepare()]
        self._idle = self._all.copy()

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

    def each(self, function: Callable[[T], R], items: Iterable[T]) -> list[R]:
        """Apply a function that runs this system to every item, several at a time."""
        return self._threads.each(function, items) if self._threads else list(map(function, items))

    def close(self) -> None:
        """Free the FMUs."""
        if self._threads:
            self._threads.shutdown(cancel_futures=True)
        for simulation in self._all:
            simulation.close()
