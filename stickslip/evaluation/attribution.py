"""What each part adds: compensator, velocity filter and feedforward of inertia, on and off."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import pandas as pd

from stickslip import cosim
from stickslip.evaluation.motions import trapezoid
from stickslip.evaluation.validation import run_motion, velocity_errors
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.rig import Rig
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop


def attribute(
    rig: Rig,
    loop: VelocityLoop,
    compensator: Mapping[str, float],
    command: cosim.Trapezoid,
    feed: Feed = "nominal",
) -> pd.DataFrame:
    """Run the trapezoid in all eight loops; return the errors of Table 4 in mm/s.

    Columns: filter, inertia, compensator (off, on), velocity (measured, true), then
    ``start E_max``, ``start E_rms``, ``reverse E_max``, ``reverse E_rms``.

    Parameters
    ----------
    loop : without filter and feedforward of inertia
    compensator : its parameters by name
    """
    filtered = with_velocity_filter(loop, rig.datasheet, compensator["F_c"])
    motion = trapezoid(command)
    rows = []
    for use_filter, inertia, compensated in itertools.product((False, True), repeat=3):
        chosen = filtered if use_filter else loop
        chosen = with_inertia(chosen) if inertia else chosen
        run = run_motion(rig, chosen, compensator if compensated else None, motion, feed)
        errors = velocity_errors(run, motion.regions)
        for velocity in run.v:
            parts = {"filter": use_filter, "inertia": inertia, "compensator": compensated}
            shown = {
                f"{region} {metric}": 1e3 * value
                for (key, region, metric), value in errors.items()
                if key == velocity
            }
            rows.append({**parts, "velocity": velocity, **shown})
    return pd.DataFrame(rows)
