"""Hands a scenario to the kernel."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cosim import kernel
from cosim.errors import ExperimentError, SignalError
from cosim.layout import Layout
from cosim.names import suggestion
from cosim.scenario import Scenario
from cosim.signals import Array

Tables = Mapping[str, tuple[Array, Array]]


def disturb(
    scenario: Scenario,
    time: Array,
    layout: Layout,
    run: kernel.Run,
    slots: Mapping[str, kernel.Component],
    external: Array,
) -> Tables:
    """Prepare a run; return the tables, which must exist as long as it.

    Parameters
    ----------
    scenario : what happens
    time : (n,) s
    layout, run, slots : of the simulation; run and slots are changed
    external : (n, number of exposed inputs); what happens to them is done here

    Raises
    ------
    SignalError
        When a name is no signal that is read or recorded, or would not be finite.
    ExperimentError
        When outputs are disturbed though the coupling is not plain.
    """
    tables = scenario.tables(time)
    if not tables and not run.disturbed:
        return tables
    for name in tables:
        if name not in layout.columns:
            raise SignalError(
                f"scenario: {name!r} is no signal of the run that is read or"
                f" recorded{suggestion(name, layout.columns)}"
            )
    for column, name in enumerate(list(layout.columns)[: external.shape[1]]):
        if name in tables:
            external[:, column] = _disturbed(external[:, column], *tables[name])
    outputs = tables.keys() - list(layout.columns)[: external.shape[1]]
    if outputs and run.coupling:
        raise ExperimentError(
            f"scenario: {', '.join(sorted(outputs))}: outputs of components can be disturbed only"
            " with a plain coupling, where no loop is solved and inputs hold"
        )
    run.disturbed = len(outputs)
    for component, slot in slots.items():
        mine = [name for name in layout.outputs[component] if name in tables]
        slot.n_disturbances = len(mine)
        slot.disturbances = (kernel.Disturbance * len(mine))(
            *(_entry(layout.columns[name], *tables[name]) for name in mine)
        )
    return tables


def _entry(column: int, keep: Array, add: Array) -> kernel.Disturbance:
    return kernel.Disturbance(column, kernel.doubles(keep), kernel.doubles(add))


def _disturbed(values: Array, keep: Array, add: Array) -> Array:
    stuck = np.isnan(keep)
    changed = np.where(stuck, values, keep * values + add)
    stuck[0] = False  # there is no step before
    last = np.maximum.accumulate(np.where(stuck, 0, np.arange(len(values))))
    result: Array = changed[last]
    return result
