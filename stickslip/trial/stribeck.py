"""Friction that falls with speed: a loop with too little damping runs away from its command.

About a steady speed v the force F of a contact approaches the curve g(v), with g' = dg/dv < 0:

    dF' = -a dF + a g' dv,   dF_f = dF + (sigma_1 / sigma_0) dF'

For the bristles of (2) to (4), a = sigma_0 v / g; for the elements of GMS, a = C / g.

Closed around the loop's compliance its fastest pole tells how a deviation grows at that speed. That
speeds are passed where it grows does not matter; that the command dwells there does.
"""

from __future__ import annotations

from collections.abc import Mapping

import control
import numpy as np

from stickslip.servo.measurement import Array
from stickslip.servo.stribeck_curve import level, slope
from stickslip.thresholds import caution
from stickslip.trial.single_run import Finding, Trial

_SPEEDS = 60


def stribeck(trial: Trial) -> list[Finding]:
    """Return a finding when deviations grow too much while the command is at low speeds."""
    if trial.law.steady == "coulomb":
        return []
    speed = np.abs(trial.v_cmd)
    top = max(float(speed.max()), 1e-9)
    grid = np.geomspace(min(1e-3 * trial.friction["v_s"], 0.1 * top), top, _SPEEDS)
    rates = np.array([growth_rate(trial, v) for v in grid])
    # Below the least speed the bristle does not slide, and holds as a spring
    at = np.maximum(np.interp(speed, grid, rates, left=0.0), 0.0)
    figure = _longest(at * trial.loop.T_s)
    if figure <= caution.GROWTH:
        return []
    worst = float(speed[at.argmax()])
    falls, damping = -float(slope(trial.friction, worst)), trial.loop.K_p + trial.loop.axis.b
    unit = trial.loop.axis.unit
    message = (
        f"at {1e3 * worst:.3g} {unit('mm/s')} friction falls by {falls:.4g} {unit('N s/m')} against"
        f" a damping K_p + b of {damping:.4g} {unit('N s/m')}, and while the command is at such"
        f" speeds a deviation grows by e^{figure:.3g}; expected at most e^{caution.GROWTH:g}; raise"
        " K_p, or pass these speeds faster"
    )
    return [Finding("stribeck", figure, caution.GROWTH, "1", message=message)]


def growth_rate(trial: Trial, v: float) -> float:
    """Return the rate [1/s] at which a small deviation from a steady speed [m/s] grows."""
    p, loop = trial.friction, trial.loop.compliance
    g = float(level(p, v))
    a, c = _approach(p, v, g), float(slope(p, v))
    stretch = p["sigma_1"] / p["sigma_0"] if "sigma_1" in p else 0.0
    if a == np.inf:
        contact = control.ss([], [], [], c, trial.loop.T_s)
    else:
        continuous = control.ss(-a, a * c, 1.0 - stretch * a, stretch * a * c)
        contact = control.sample_system(continuous, trial.loop.T_s)
    A = np.block(
        [
            [loop.A - loop.B @ contact.D @ loop.C, -loop.B @ contact.C],
            [contact.B @ loop.C, contact.A],
        ]
    )
    return float(np.log(np.abs(np.linalg.eigvals(A)).max()) / trial.loop.T_s)


def _approach(p: Mapping[str, float], v: float, g: float) -> float:
    """Return the rate [1/s] at which the force approaches g(v); infinite without presliding."""
    if "C" in p:
        return p["C"] / g
    return p["sigma_0"] * v / g if "sigma_0" in p else np.inf


def _longest(growth: Array) -> float:
    """Return the largest sum over samples in a row that are not 0."""
    ends = np.flatnonzero(np.diff(growth > 0.0, prepend=False, append=False))
    total = np.concatenate([[0.0], np.cumsum(growth)])
    sums = total[ends[1::2]] - total[ends[::2]]
    return float(sums.max(initial=0.0))
