"""Hands to the kernel what a scenario does to signals, and to tunable parameters during a run.

Source: FMI 2.0 section 2.2.7, FMI 3.0 section 2.4.7 (variability ``tunable``: between communication
points, and where events are known, in event mode).
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.cosim.assembly.general_path import GeneralComponent
from stickslip.cosim.assembly.layout import Layout
from stickslip.cosim.errors import ParameterError, SignalError
from stickslip.cosim.fmu.batch import Batch
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.fmu.values import converted
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.scenario import Disturbance, Tables
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.scaling import Scaling
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value
from stickslip.fmi.messages import suggestion


def split(tables: Tables, layout: Layout, system: System) -> tuple[Tables, Tables]:
    """Return what happens to signals, and what to parameters.

    A connected input stands for its source, where that has no other target.
    """
    sources = system.sources() if tables.keys() - layout.columns.keys() else {}
    signals: dict[str, Disturbance] = {}
    for name, table in tables.items():
        if name in sources or name in layout.columns:
            source = sources.get(name, name)
            if source in signals:
                raise SignalError(
                    f"scenario: {name} is {source}, which occurs already; name it once"
                )
            signals[source] = table if source == name else _at_source(name, table, sources, system)
    others = {name: t for name, t in tables.items() if name not in (layout.columns | sources)}
    for name in others:
        try:
            variable = system.variable(name, SignalError)
        except SignalError:
            variable = None
        if variable is None or variable.causality != "parameter":
            raise SignalError(
                f"scenario: {name!r} is not a signal of the run that is read or recorded, nor a"
                f" parameter{suggestion(name, layout.columns)}"
            )
        if variable.variability != "tunable" or not variable.is_signal or variable.array:
            kind = "array" if variable.array or variable.dimensions else variable.type
            raise SignalError(
                f"scenario: {name} is a {variable.variability} parameter ({kind}); only tunable"
                " ones that are a number or Boolean change during a run; set it before"
            )
    return signals, others


def _at_source(
    name: str, table: Disturbance, sources: Mapping[str, str], system: System
) -> Disturbance:
    """Return what happens to an input as if it happened to its source."""
    source = sources[name]
    if receivers := [target for target in sources if sources[target] == source and target != name]:
        raise SignalError(
            f"scenario: {name} is connected to {source}, which is also connected to "
            f"{', '.join(receivers)} and is disturbed as a whole: name {source}"
        )
    line = system.scaling(source, name)
    if not isinstance(line, Scaling) or line.factor == 0:
        raise SignalError(f"scenario: the values of {name} are mapped; name {source}")
    return table.in_unit(line.factor, line.offset)


def tune(
    tables: Tables,
    values: Mapping[str, Value],
    system: System,
    libraries: Mapping[str, Library],
    general_components: Mapping[str, GeneralComponent],
    order: Sequence[str],
) -> list[tuple[int, structures.Change, Any]]:
    """Return the changes of parameters in the order of time: step, change and what it points to.

    Parameters
    ----------
    tables : what happens to them
    values : their start values, where these are not those of the FMUs
    order : of the components in the kernel's table
    """
    changes = []
    for name, table in tables.items():
        variable = system.variable(name)
        start = values.get(name, variable.start)
        if not isinstance(start, int | float):
            raise SignalError(f"scenario: {name} has no start value; set one")
        series = table.at_points(np.full(len(table.keep), float(start)))
        before = np.append(float(start), series[:-1])
        component = component_of(name)
        for step in np.flatnonzero(series != before):
            value = float(series[step])
            try:
                whole = int(value) if value.is_integer() else value
                checked = converted(variable, whole, name)
            except ParameterError as fault:
                raise SignalError(f"scenario: {fault}") from None
            batch = Batch(libraries[component], [variable], "Set")
            batch.put(variable, checked)
            setting, kept = _setting(batch, general_components.get(component))
            change = structures.Change(int(step), order.index(component), setting)
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


def disturb(
    tables: Tables,
    layout: Layout,
    run: structures.Run,
    slots: Mapping[str, structures.Component],
    external: Array,
    ends: Array,
) -> None:
    """Prepare a run.

    Parameters
    ----------
    tables : what happens to signals; must exist as long as the run
    layout, run, slots : of the simulation; run and slots are changed
    external, ends : (n, number of exposed inputs), at the points in time and at the end of the step
        before each; what happens to them is done here
    """
    inputs = list(layout.columns)[: external.shape[1]]
    for column, name in enumerate(inputs):
        if name in tables:
            ends[:, column] = tables[name].at_ends(ends[:, column], external[:, column])
            external[:, column] = tables[name].at_points(external[:, column])
    run.disturbed = len(tables.keys() - inputs)
    for component, slot in slots.items():
        mine = [name for name in layout.outputs[component] if name in tables]
        slot.n_disturbances = len(mine)
        slot.disturbances = (structures.Disturbance * len(mine))(
            *(_entry(layout.columns[name], tables[name]) for name in mine)
        )


def _entry(column: int, table: Disturbance) -> structures.Disturbance:
    return structures.Disturbance(
        column, *map(structures.doubles, (table.keep, table.add, table.ends))
    )


def held_values(slots: Mapping[str, structures.Component], row: Array, done: int) -> Array:
    """Return for each signal the value that it keeps if it sticks from now on, (width,).

    Parameters
    ----------
    row : (width,) all signals after the last step done
    done : number of that step
    """
    values = row.copy()
    for entry in _entries(slots):
        if np.isnan(entry.keep[done]):
            values[entry.column] = entry.held
    return values


def hold_values(slots: Mapping[str, structures.Component], values: Array) -> None:
    """Let signals that stick keep the values (width,) that ``held_values`` returned."""
    for entry in _entries(slots):
        entry.held = values[entry.column]


def _entries(slots: Mapping[str, structures.Component]) -> list[structures.Disturbance]:
    return [slot.disturbances[i] for slot in slots.values() for i in range(slot.n_disturbances)]
