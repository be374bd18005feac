"""The exposed inputs of a system at the points in time of a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.cosim.errors import SignalError
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.fmu.values import integer_range
from stickslip.cosim.signals.signals import Array, Input, Table, ends_of, sampled, shifted
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
