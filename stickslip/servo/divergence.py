"""A simulated loop that runs away from its command: its run has failed, and gives no figures."""

from __future__ import annotations

import numpy as np

from stickslip import cosim
from stickslip.servo.measurement import Array
from stickslip.thresholds import loop_fit


class Diverged(cosim.SimulationError):
    """A simulated drive ran away from its command."""


def require_bounded(v: Array, speed: float) -> None:
    """Raise where a simulated velocity is not finite, or far beyond what was commanded.

    Raises Diverged when it has run away.

    Parameters
    ----------
    v : (n,) of the drive [m/s]
    speed : the largest one that is commanded, at any time of the trial [m/s]
    """
    peak = float(np.max(np.abs(v)))
    if not peak <= loop_fit.RUNS_AWAY * speed:
        raise Diverged(
            f"the simulated loop runs away: its velocity exceeds {loop_fit.RUNS_AWAY:g} times the "
            "largest commanded one; expected a loop that is stable with these gains; check their "
            "units and signs, the delay and the mass"
        )
