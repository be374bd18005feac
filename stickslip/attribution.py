"""What each part adds: compensator, velocity filter and feedforward of inertia, on and off."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import pandas as pd

import cosim
from cosim.control import VelocityLoop
from stickslip.filtered import with_inertia, with_velocity_filter
from stickslip.loop import Feed
from stickslip.rig import Rig
from stickslip.validation import run_command, tracking_errors, windows


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
    v_cmd = command.sample(rig.samples(command.corners()[-1] + command.begin))
    rows = []
    for use_filter, inertia, compensated in itertools.product((False, True), repeat=3):
        chosen = filtered if use_filter else loop
        chosen = with_inertia(chosen) if inertia else chosen
        run = run_command(rig, chosen, compensator if compensated else None, v_cmd, feed)
        for velocity, v in run.v.items():
            rows.append(
                {
                    "filter": use_filter,
                    "inertia": inertia,
                    "compensator": compensated,
                    "velocity": velocity,
                    **{
                        f"{region} {metric}": 1e3 * value
                        for region, instant in windows(command).items()
                        for metric, value in tracking_errors(run.t, run.v_cmd - v, instant).items()
                    },
                }
            )
    return pd.DataFrame(rows)
