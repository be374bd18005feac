"""Hands to the kernel what a scenario does to signals."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cosim import kernel
from cosim.layout import Layout
from cosim.scenario import Tables
from cosim.signals import Array


def disturb(
    tables: Tables,
    layout: Layout,
    run: kernel.Run,
    slots: Mapping[str, kernel.Component],
    external: Array,
) -> None:
    """Prepare a run.

    Parameters
    ----------
    tables : what happens to signals; must exist as long as the run
    layout, run, slots : of the simulation; run and slots are changed
    external : (n, number of exposed inputs); what happens to them is done here
    """
    for column, name in enumerate(list(layout.columns)[: external.shape[1]]):
        if name in tables:
            external[:, column] = disturbed(external[:, column], *tables[name])
    outputs = tables.keys() - list(layout.columns)[: external.shape[1]]
    run.disturbed = len(outputs)
    for component, slot in slots.items():
        mine = [name for name in layout.outputs[component] if name in tables]
        slot.n_disturbances = len(mine)
        slot.disturbances = (kernel.Disturbance * len(mine))(
            *(_entry(layout.columns[name], *tables[name]) for name in mine)
        )


def _entry(column: int, keep: Array, add: Array) -> kernel.Disturbance:
    return kernel.Disturbance(column, kernel.doubles(keep), kernel.doubles(add))


def disturbed(values: Array, keep: Array, add: Array) -> Array:
    """Return a signal as a scenario changes it, (n,)."""
    stuck = np.isnan(keep)
    changed = np.where(stuck, values, keep * values + add)
    stuck[0] = False  # there is no step before
    last = np.maximum.accumulate(np.where(stuck, 0, np.arange(len(values))))
    result: Array = changed[last]
    return result
