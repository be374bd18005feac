"""What each part adds: compensator, velocity filter and feedforward of inertia, on and off."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import pandas as pd

from stickslip import cosim
from stickslip.evaluation.comparison import Entry, evaluate
from stickslip.evaluation.motions import trapezoid
from stickslip.evaluation.scatter import PHASES
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop


def attribute(
    rig: FmuRig,
    loop: VelocityLoop,
    compensator: Mapping[str, float],
    command: cosim.Trapezoid,
    feed: Feed = "nominal",
) -> pd.DataFrame:
    """Run the trapezoid in all eight loops; return the errors of Table 4 in mm/s.

    They are medians over ``PHASES``. Columns: filter, inertia, compensator (off, on), velocity
    (measured, true), then ``start E_max``, ``start E_rms``, ``reverse E_max``, ``reverse E_rms``.

    Parameters
    ----------
    loop : without filter and feedforward of inertia
    compensator : its parameters by name
    """
    filtered = with_velocity_filter(loop, rig.datasheet, compensator["F_c"])
    names, entries = ["filter", "inertia", "compensator"], {}
    for parts in itertools.product((False, True), repeat=3):
        use_filter, inertia, compensated = parts
        chosen = filtered if use_filter else loop
        chosen = with_inertia(chosen) if inertia else chosen
        entries[str(parts)] = Entry(chosen, compensator if compensated else None)
    table = evaluate(rig, entries, feed, [trapezoid(command)], PHASES).table()
    table.index = pd.Index(table["region"] + " " + table["metric"])
    rows = []
    for parts in itertools.product((False, True), repeat=3):
        for velocity in dict.fromkeys(table["velocity"]):
            errors = table[table["velocity"] == velocity][str(parts)]
            rows.append({**dict(zip(names, parts, strict=True)), "velocity": velocity, **errors})
    return pd.DataFrame(rows)
