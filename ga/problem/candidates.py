"""Candidates evaluated by running a cosim simulation: the one place here that knows cosim."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self
from uuid import uuid4

from stickslip import cosim
from stickslip.cosim.signals.signals import Input
from stickslip.ga.errors import CandidateFailed
from stickslip.ga.problem.problem import Array

_Worker = tuple[int, int]  # process and thread; a forked process must not use its parent's FMUs
_open: dict[tuple[str, _Worker], cosim.Simulation] = {}


@dataclass(frozen=True)
class SimulatedCost:
    """Cost of a candidate: set its values as parameters, run the system, evaluate the result.

    It pickles. Every worker, thread or process, prepares one simulation when it evaluates its first
    candidate and keeps it for the others. `close`, or leaving a ``with`` block, frees those of
    this process; the ones of other processes end with them.

    Parameters
    ----------
    specification : the system, step, stop and recorded variables
    names : the parameter ``component.variable`` that each value of a candidate sets
    cost : evaluates a result, 0 .. inf, or to a dictionary
    inputs : exposed input -> array, signal or number, the same for every candidate
    """

    fatal: ClassVar = (cosim.CosimError,)
    """What no candidate is to blame for."""

    specification: cosim.Specification
    names: Sequence[str]
    cost: Callable[[cosim.Result], Any]
    inputs: Mapping[str, Input] = field(default_factory=dict)
    _token: str = field(default_factory=lambda: uuid4().hex, init=False, repr=False)

    def __call__(self, values: Array) -> Any:
        """Run one candidate (k,), in the order of `names` and in their units; return its cost.

        Raises
        ------
        CandidateFailed : an FMU failed during the run
        cosim.CosimError : the system, a name or an input is wrong, whatever the candidate
        Exception : what `cost` raises
        """
        return self.cost(self.result(values))

    def result(self, values: Array) -> cosim.Result:
        """Run one candidate (k,) and return what was recorded; errors are those of a call."""
        parameters = dict(zip(self.names, values.tolist(), strict=True))
        try:
            return self._simulation().run(parameters=parameters, inputs=self.inputs)
        except cosim.SimulationError as error:
            raise CandidateFailed(str(error)) from error

    def close(self) -> None:
        """Free this cost's simulations in this process; a later call prepares them again."""
        for key in [key for key in _open if key[0] == self._token and key[1][0] == os.getpid()]:
            # The costs are known; one that still runs frees its FMUs when its thread lets go of it.
            with suppress(cosim.FmuCrashed, cosim.SharedSimulation):
                _open.pop(key).close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _simulation(self) -> cosim.Simulation:
        key = self._token, (os.getpid(), threading.get_ident())
        if key not in _open:
            _open[key] = self.specification.prepare()
        return _open[key]
