"""Hands to the kernel what a scenario does to signals."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.cosim.assembly.layout import Layout
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.scenario import Disturbance, Tables
from stickslip.cosim.signals.signals import Array


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
