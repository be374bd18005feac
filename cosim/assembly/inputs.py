"""The exposed inputs of a system: at the points in time of a run, and where they jump between."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping

import numpy as np

from stickslip.cosim.errors import SignalError
from stickslip.cosim.fmu.names import component_of, variable_of
from stickslip.cosim.fmu.values import integer_range
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.signals import Array, Input, Table, ends_of, sampled, shifted
from stickslip.cosim.signals.span import slack
from stickslip.cosim.system.scaling import IDENTITY
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value, Variable
from stickslip.fmi.messages import suggestion

WHOLE = {"Boolean", "integer", "enumeration"}
"""Families of types that take whole numbers."""


def sample_inputs(
    system: System, starts: Mapping[str, Value], inputs: Mapping[str, Input], time: Array
) -> Array:
    """Return the exposed inputs over time, (n, number of exposed inputs).

    Raises
    ------
    SignalError
        When there is no such input, or it cannot have such values.
    """
    table = np.empty((len(time), len(system.inputs)))
    for i, (name, targets) in enumerate(system.inputs.items()):
        if name not in inputs:
            start = _start(system, starts, targets[0])
            table[:, i] = system.scaling(name, targets[0]).inverse(start)
    put_inputs(system, inputs, time, table)
    return table


def put_inputs(system: System, inputs: Mapping[str, Input], time: Array, table: Array) -> None:
    """Put inputs over time into the columns of a table that they have there.

    The arguments are those of ``sample_inputs``, and so are the errors.
    """
    places = {name: i for i, name in enumerate(system.inputs)}
    for name, signal in inputs.items():
        if name not in places:
            raise SignalError(
                f"{system.name} has no exposed input {name!r}{suggestion(name, places)}"
            )
        targets, column = system.inputs[name], table[:, places[name]]
        if isinstance(signal, Table) and system.variable(targets[0]).is_discrete:
            signal = signal.hold(time)
        column[:] = sampled(name, signal, time)
        for target in targets:
            variable = system.variable(target)
            if variable.family in WHOLE and system.scaling(name, target) == IDENTITY:
                _require_whole(name, variable, column, time)


def sample_ends(system: System, inputs: Mapping[str, Input], time: Array, external: Array) -> Array:
    """Return the exposed inputs at the end of the step before each point in time.

    They differ from those at the points, ``external``, where an input jumps: what is discrete or
    held has the value of the point before.
    """
    ends = external.copy()
    for i, (name, targets) in enumerate(system.inputs.items()):
        if system.variable(targets[0]).is_discrete:
            ends[:, i] = shifted(external[:, i])
        elif name in inputs:
            ends[:, i] = ends_of(inputs[name], external[:, i], time)
    return ends


def _require_whole(name: str, variable: Variable, values: Array, time: Array) -> None:
    """Raise SignalError where an input that is Boolean or an integer cannot take a value."""
    low, high = integer_range(variable)
    wrong = (values != np.rint(values)) | (values < low) | (values > high)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise SignalError(
            f"input {name!r} is {values[k]:.9g} at t = {time[k]:.9g} s; expected whole numbers from"
            f" {low} to {high}, because {variable.name} is of type {variable.type}"
        )


def _start(system: System, starts: Mapping[str, Value], target: str) -> float:
    """Return the start value of an input, which may be an element of an array."""
    variable = system.variable(target)
    whole = starts.get(f"{component_of(target)}.{variable.owner}")
    start = starts.get(target, whole[variable.element] if isinstance(whole, tuple) else None)
    start = variable.start if start is None else start
    return float(start) if isinstance(start, int | float) else 0.0


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
