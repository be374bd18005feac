"""Jumps of exposed inputs between two points in time, at which the FMUs are to stop."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping

import numpy as np

from stickslip.cosim.fmu.names import component_of, variable_of
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.signals import Array, Input, Table, sampled
from stickslip.cosim.signals.span import slack
from stickslip.cosim.system.system import System


class InputEvents:
    """What a run does between its points in time; must exist as long as the run.

    Parameters
    ----------
    inputs, tables : of the exposed inputs, all and those that are tables
    time, external : the points in time (s), and the inputs there

    Attributes
    ----------
    times : (n,) s
    steps : (n,) the step in which each lies
    values : (n, number of exposed inputs), from then on
    """

    def __init__(
        self,
        system: System,
        inputs: Mapping[str, Input],
        tables: Mapping[str, Table],
        time: Array,
        external: Array,
    ) -> None:
        discrete = {n: system.variable(system.inputs[n][0]).is_discrete for n in tables}
        jumps = [table.jumps(discrete=discrete[name]) for name, table in tables.items()]
        self.times, self.steps = _between(np.unique(np.concatenate([*jumps, []])), time)
        self.values: Array = external[self.steps]
        for i, name in enumerate(system.inputs if len(self.times) else ()):
            signal = inputs.get(name)
            if discrete.get(name):
                self.values[:, i] = tables[name].hold(self.times)
            elif signal is not None and (hasattr(signal, "sample") or callable(signal)):
                self.values[:, i] = sampled(name, signal, self.times)

    def attach(self, run: structures.Run) -> None:
        """Let a run, which is about to begin, stop at these."""
        n = run.n_events = len(self.times)
        run.events = (structures.InputEvent * n)(
            *map(structures.InputEvent, self.steps.tolist(), self.times.tolist())
        )
        run.parts = (ctypes.c_double * (2 * run.width if n else 0))()
        run.event_inputs = structures.doubles(self.values)


def joined(time: Array, ends: Array, values: Array) -> Table:
    """Return straight lines between the points in time, each from a value to the end of its step.

    Parameters
    ----------
    time, ends, values : (n,) the points, the ends of the steps before each, the values there
    """
    jumps = np.flatnonzero(ends != values)
    return Table(np.insert(time, jumps, time[jumps]), np.insert(values, jumps, ends[jumps]))


def courses(system: System, component: str, tables: Mapping[str, Table]) -> dict[str, Table]:
    """Return the tables that inputs of a component follow, by input and in its unit.

    Clocks follow none: they tick at the points in time at which their input is not 0.
    """
    found = {}
    for name, table in tables.items():
        for target in system.inputs[name]:
            variable = system.variable(target)
            if component_of(target) == component and variable.type != "Clock":
                transform = system.scaling(name, target)
                values = np.array([transform(x) for x in table.values.tolist()])
                held = table.held or variable.is_discrete
                found[variable_of(target)] = Table(table.time, values, held=held)
    return found


def _between(
    times: Array, points: Array
) -> tuple[Array, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Return those of the times that lie between two points, and after which of them."""
    times = times[(times > points[0]) & (times < points[-1])]
    steps = np.searchsorted(points, times, side="right") - 1
    near = slack(times, (points[-1] - points[0]) / (len(points) - 1))
    apart = np.minimum(times - points[steps], points[steps + 1] - times) > near
    apart &= np.append(times[1:], np.inf) - times > near  # of several at one time the last
    return times[apart], steps[apart]
