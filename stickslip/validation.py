"""Section 4.2: the trapezoid with and without compensation, judged by (8a), (8b) and (9)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

import cosim
from cosim.control import VelocityLoop
from stickslip.loop import Feed, paper_loop
from stickslip.measurement import Array, measured_velocity
from stickslip.rig import Rig
from stickslip.setup import REGION

PAPER_TABLE4 = {
    ("start", "E_max"): (0.98, 0.76),
    ("start", "E_rms"): (0.86, 0.48),
    ("reverse", "E_max"): (1.76, 0.72),
    ("reverse", "E_rms"): (1.62, 0.44),
}
"""Table 4, without and with compensation; it prints no unit, and mm/s is the reading that fits."""

METRICS = ("E_max", "E_rms")

RECORD = ("drive.x_enc", "drive.v", "drive.F_f", "nominal.v_r", "compensator.F_mean")


@dataclass(frozen=True)
class Run:
    """The trapezoid once.

    Attributes
    ----------
    t, v_cmd : (n,) [s], [m/s]
    x_enc : position (n,) [m] that the encoder shows
    v : velocity (n,) [m/s] by what shows it, ``measured`` or ``true``
    v_r : response of the nominal loop (n,) [m/s]
    F_f, F_ff : the drive's true friction, and the force of the compensator (n,) [N]
    """

    t: Array
    v_cmd: Array
    x_enc: Array
    v: dict[str, Array]
    v_r: Array
    F_f: Array
    F_ff: Array


@dataclass(frozen=True)
class Validation:
    """Both runs, and the instants at which motion starts and reverses [s]."""

    without: Run
    compensated: Run
    instants: dict[str, float]

    def table(self) -> pd.DataFrame:
        """Return Table 4 beside the paper's; velocities in mm/s, reductions as fractions (9)."""
        rows = []
        for velocity in ("measured", "true"):
            for region, instant in self.instants.items():
                errors = [
                    tracking_errors(run.t, run.v_cmd - run.v[velocity], instant)
                    for run in (self.without, self.compensated)
                ]
                for metric in METRICS:
                    without, compensated = (1e3 * error[metric] for error in errors)
                    paper = PAPER_TABLE4[region, metric]
                    rows.append(
                        {
                            "velocity": velocity,
                            "region": region,
                            "metric": metric,
                            "without": without,
                            "with": compensated,
                            "reduction": reduction(without, compensated),
                            "paper_without": paper[0],
                            "paper_with": paper[1],
                            "paper_reduction": reduction(*paper),
                        }
                    )
        return pd.DataFrame(rows)


def tracking_errors(
    t: Array, error: Array, instant: float, region: tuple[float, float] = REGION
) -> dict[str, float]:
    """Return (8a) and (8b) of an error (n,), from when to when (s) after an instant [s].

    The unit is that of the error.
    """
    begin, end = (instant + edge for edge in region)
    half = 0.5 * (t[1] - t[0])
    part = error[(t >= begin - half) & (t <= end + half)]
    return {
        "E_max": float(np.abs(part).max()),
        "E_rms": float(np.sqrt(np.mean(part**2))),
    }


def reduction(without: float, compensated: float) -> float:
    """Return the error reduction ratio (9)."""
    return (without - compensated) / without


def windows(command: cosim.Trapezoid) -> dict[str, float]:
    """Return the instants [s] at which motion starts and reverses."""
    corners = command.corners()
    return {"start": float(corners[0]), "reverse": float(corners[2:4].mean())}


def validate(
    rig: Rig,
    loop: VelocityLoop,
    compensator: Mapping[str, float],
    command: cosim.Trapezoid,
    feed: Feed = "nominal",
    plain: VelocityLoop | None = None,
) -> Validation:
    """Run the trapezoid without and with compensation. This judges; it may see the truth.

    Parameters
    ----------
    plain : the loop of the run without compensation, by default ``loop``. A velocity filter that
        counts on a compensator follows worse without: compare it with the loop it replaces.
    """
    v_cmd = command.sample(rig.samples(command.corners()[-1] + command.begin))
    without = run_command(rig, plain or loop, None, v_cmd, feed)
    compensated = run_command(rig, loop, compensator, v_cmd, feed)
    return Validation(without, compensated, windows(command))


def run_command(
    rig: Rig,
    loop: VelocityLoop,
    compensator: Mapping[str, float] | None,
    v_cmd: Array,
    feed: Feed = "nominal",
) -> Run:
    """Run a velocity command (n,) [m/s], one value a sample, with a compensator or None."""
    system = paper_loop(rig.fmus, loop, compensator, feed)
    stop = (len(v_cmd) - 1) * rig.T_s
    with system.prepare(step=rig.T_s, stop=stop, record=RECORD) as simulation:
        result = simulation.run(inputs=loop.commands(v_cmd))
    velocity = {
        "measured": measured_velocity(result["drive.x_enc"], rig.T_s),
        "true": result["drive.v"],
    }
    return Run(
        result.time,
        v_cmd,
        result["drive.x_enc"],
        velocity,
        result["nominal.v_r"],
        result["drive.F_f"],
        result["compensator.F_mean"],
    )
