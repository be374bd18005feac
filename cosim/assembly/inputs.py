"""Exposed inputs and tunable parameters over a run."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any

import numpy as np

from stickslip.cosim.assembly.general_path import GeneralComponent
from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.component import component_of, converted, integer_range, variable_of
from stickslip.cosim.errors import ParameterError, SignalError
from stickslip.cosim.fmu.instance import Batch
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.signals import Array, Input, Table, ends_of, sampled, shifted, slack
from stickslip.cosim.system.scaling import IDENTITY
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value, Variable
from stickslip.fmi.messages import suggestion

WHOLE = {"Boolean", "integer", "enumeration"}  # families of types that take whole numbers


def sample_inputs(
    system: System, starts: Mapping[str, Value], inputs: Mapping[str, Input], time: Array
) -> Array:
    """Return the exposed inputs over time, (n, number of exposed inputs)."""
    table = np.empty((len(time), len(system.inputs)))
    for i, (name, targets) in enumerate(system.inputs.items()):
        if name not in inputs:
            start = _start(system, starts, targets[0])
            table[:, i] = system.scaling(name, targets[0]).inverse(start)
    put_inputs(system, inputs, time, table)
    return table


def put_inputs(system: System, inputs: Mapping[str, Input], time: Array, table: Array) -> None:
    """Put inputs over time into the columns of a table that ``sample_inputs`` returned."""
    places = {name: i for i, name in enumerate(system.inputs)}
    for name, signal in inputs.items():
        if name not in places:
            near = suggestion(name, places)
            raise SignalError(f"{system.name} has no exposed input {name!r}{near}")
        targets, column = system.inputs[name], table[:, places[name]]
        if isinstance(signal, Table) and system.variable(targets[0]).is_discrete:
            signal = signal.hold(time)
        column[:] = sampled(name, signal, time)
        for target in targets:
            variable = system.variable(target)
            if variable.family in WHOLE and system.scaling(name, target) == IDENTITY:
                _require_whole(name, variable, column, time)


def sample_ends(system: System, inputs: Mapping[str, Input], time: Array, external: Array) -> Array:
    """Return the inputs at the end of the step before each point; other ones where they jump."""
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
    """Times (n,) in s between the points, their steps, and inputs (n, number) from then on.

    Must exist as long as the run. ``tables`` are those of the ``inputs`` that are tables,
    ``external`` the inputs at the points in time.
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
        events = map(structures.InputEvent, self.steps.tolist(), self.times.tolist())
        run.events = (structures.InputEvent * n)(*events)
        run.parts = (ctypes.c_double * (2 * run.width if n else 0))()
        run.event_inputs = structures.doubles(self.values)


def courses(system: System, component: str, tables: Mapping[str, Table]) -> dict[str, Table]:
    """Return the tables that inputs, but for clocks, of a component follow, in their units."""
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


def tune(
    tunable: Mapping[str, Input],
    values: Mapping[str, Value],
    plan: Plan,
    libraries: Mapping[str, Library],
    general_components: Mapping[str, GeneralComponent],
) -> list[tuple[int, structures.Change, Any]]:
    """Return the changes of parameters in the order of time: step, change and what it points to."""
    changes = []
    for name, signal in tunable.items():
        time = plan.time
        variable = plan.spec.system.variable(name, SignalError)
        if variable.causality != "parameter" or variable.variability != "tunable":
            what = f"{name} is a {variable.variability} {variable.causality}"
            raise SignalError(f"{what}; only tunable parameters change during a run")
        if not variable.is_signal or variable.array:
            kind = "array" if variable.array or variable.dimensions else variable.type
            raise SignalError(f"{name} is of type {kind}, expected a number or Boolean to change")
        start = values.get(name, variable.start)
        if not isinstance(start, int | float):
            raise SignalError(f"{name} has no start value; set one")
        if isinstance(signal, Table) and variable.is_discrete:
            signal = signal.hold(time)
        series = np.broadcast_to(sampled(name, signal, time), time.shape)
        component = component_of(name)
        for step in np.flatnonzero(series != np.append(float(start), series[:-1])):
            value = float(series[step])
            try:
                checked = converted(variable, int(value) if value.is_integer() else value, name)
            except ParameterError as fault:
                raise SignalError(str(fault)) from None
            batch = Batch(libraries[component], [variable], "Set")
            batch.put(variable, checked)
            setting, kept = _setting(batch, general_components.get(component))
            change = structures.Change(int(step), plan.order.index(component), setting)
            changes.append((int(step), change, (batch, kept)))
    return sorted(changes, key=lambda change: change[0])


def _setting(batch: Batch, general: GeneralComponent | None) -> tuple[structures.Setting, Any]:
    """Return what the kernel calls, and what it points to beside the batch."""
    address, values = batch.address, batch.values
    if general:
        address, values = general.tune_call(), ctypes.pointer(batch.group())
    setting = structures.Setting(
        set=address,
        call=batch.call.encode(),
        n=len(batch.references),
        references=batch.references,
        values=ctypes.cast(values, ctypes.c_void_p),
    )
    return setting, values
