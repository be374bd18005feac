"""The runs of stage 2: force at constant velocities, forth and back along the guide.

What depends on the position alone, such as the motor's force ripple, cancels between the
directions. Friction varies along the guide in the same proportion at each speed; the fast runs,
which travel all of it, show how, so that the slow ones need not go far.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.errors import IdentificationError
from stickslip.rigs.contract import Rig
from stickslip.servo.measurement import Array, smoothed
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.thresholds import stage

SPEEDS = np.geomspace(0.25e-3, 40e-3, 12)  # [m/s]
FAST = 3e-3  # from this speed on the whole guide is travelled, below it the beginning [m/s]
GUIDE, BEGINNING = 0.100, 0.010  # [m]
BLOCK = 0.0025  # of the guide, over which the force is averaged [m]
SETTLE, LEAD = 2.0, 0.010  # before that, at most [s] and [m]
SLOW = 20.0  # frequency below which the fluctuation of a speed counts [Hz]


@dataclass(frozen=True)
class Sliding:
    """Friction at the n speeds that the loop holds."""

    speed: Array  # (n,) [m/s]
    # (n,) motor force in either direction, with its sign [N]
    forward: Array
    back: Array
    # (n,) half their difference, and its standard error [N]
    friction: Array
    error: Array
    along: Array  # (k,) friction in each block of the guide, relative to its mean
    # most that the velocity can fluctuate about its mean, a standard deviation [m/s]
    fluctuation: float


def measure_sliding(rig: Rig, loop: VelocityLoop) -> Sliding:
    """Drive at each of the speeds; friction is that of the mean of the guide.

    Where the stage sticks and slips the mean force is not that of the mean speed: no such run
    counts. Raises IdentificationError when too few speeds are held.
    """
    tried = [_forth_and_back(rig, loop, speed) for speed in SPEEDS]
    held = [run is not None for run in tried]
    if sum(held) < stage.SPEEDS_HELD:
        raise IdentificationError(
            f"constant velocity: the loop holds {sum(held)} of {len(held)} speeds from "
            f"{SPEEDS[0]:g} to {SPEEDS[-1]:g} m/s within {100.0 * stage.HELD:.0f} %, expected at "
            f"least {stage.SPEEDS_HELD:g}; check tau_i and encoder_step of the data sheet, or "
            "raise the bandwidth"
        )
    runs = [run for run in tried if run is not None]
    halves = [0.5 * (forces[0] - forces[1]) for forces, _ in runs]
    along = np.mean([f / f.mean() for f in halves if len(f) == round(GUIDE / BLOCK)], axis=0)
    level = [(forces / along[: forces.shape[1]]).mean(axis=1) for forces, _ in runs]
    rest = [half / along[: len(half)] for half in halves]
    return Sliding(
        speed=SPEEDS[held],
        forward=np.array([force[0] for force in level]),
        back=np.array([force[1] for force in level]),
        friction=np.array([f.mean() for f in rest]),
        error=np.array([f.std(ddof=1) / np.sqrt(len(f)) for f in rest]),
        along=along,
        fluctuation=float(np.mean([fluctuation for _, fluctuation in runs])),
    )


def _forth_and_back(rig: Rig, loop: VelocityLoop, speed: float) -> tuple[Array, float] | None:
    """Return the mean force (2, k) [N] in each block, forward and back, and the fluctuation [m/s].

    None where the loop does not hold the speed.

    The velocity does not fluctuate more than the motor force would make the mass alone do.
    """
    reach = GUIDE if speed >= FAST else BEGINNING
    settle, travel = min(SETTLE, LEAD / speed), reach / speed
    turn = settle, 3.0 * settle + travel  # from before the guide to behind it, and back [s]
    t = rig.samples(turn[1] + 2.0 * settle + travel)
    log = rig.follow(speed * np.where((t < turn[0]) | (t >= turn[1]), -1.0, 1.0), loop)
    block = np.floor(log.x_enc / BLOCK)
    forward = (t >= turn[0] + 0.5 * settle) & (t < turn[1])
    back = t >= turn[1] + 0.5 * settle
    n = round(reach / BLOCK)
    v = np.gradient(smoothed(log.x_enc, rig.T_s, SLOW), rig.T_s)
    parts = [[way & (block == k) for k in range(n)] for way in (forward, back)]
    for part in parts:
        if not (all(map(np.any, part)) and np.std(v[np.any(part, axis=0)]) < stage.HELD * speed):
            return None
    forces = [[log.F_m[samples].mean() for samples in part] for part in parts]
    free = np.cumsum(log.F_m) * rig.T_s / loop.axis.m
    return np.array(forces), float(np.std((free - smoothed(free, rig.T_s))[forward]))
