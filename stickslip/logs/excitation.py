"""How a recording excites a drive."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stickslip.logs.motion import Kinematics, kinematics, rigid
from stickslip.logs.recording import Recording
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import log_content

SLOW = 0.01  # share of the top speed below which motion counts as slow
TURNED = 0.63  # share of its swing that friction covers during a reversal


@dataclass(frozen=True)
class TurnAround:
    """Reversals of friction after those of velocity: medians, which the low-pass makes longer."""

    distance: float  # of motion until friction made 63 % of its swing [m]
    counts: float  # steps of the encoder in it; inf where no step shows
    samples: float  # in it
    times: int  # how often


@dataclass(frozen=True)
class Excitation:
    """Figures of a recording."""

    top_speed: float  # [m/s]
    moving: float  # share of the time faster than the encoder's floor
    slow_speed: float  # a hundredth of the top speed, or three times the encoder's floor [m/s]
    slow: float  # share of the moving time that is slower
    slow_samples: int  # as many samples
    speeds: tuple[float, float]  # 5 % and 95 % of the moving time are slower [m/s]
    reversals: int  # of the direction
    one_way: bool  # whether it moves in one direction only, by ``log_content.ONE_WAY``
    spacing: float  # median samples between two reversals; inf with fewer
    acceleration: float  # 99 % of the samples have less [m/s^2]
    mass: float  # of a rigid drive with Coulomb and viscous friction, fitted while sliding [kg]
    coulomb: float  # the same drive's Coulomb friction [N]
    # share of the force's standard deviation, while sliding, that acceleration causes; nan, as
    # both, where too little slides or no force is known
    inertial: float
    turn_around: TurnAround | None  # reversal of friction; None where it cannot be measured


def excitation(recording: Recording) -> Excitation:
    """Return the figures of a recording that has a position or a velocity."""
    motion = kinematics(recording)
    speed = np.abs(motion.v)
    top = float(speed.max())
    moving = speed > motion.floor
    share = float(np.mean(moving))
    slow_speed = max(SLOW * top, 3 * motion.floor)
    slow = moving & (speed < slow_speed)
    low, high = np.quantile(speed[moving], (0.05, 0.95)) if moving.any() else (0.0, 0.0)
    turns = reversals(recording, motion)
    fit, inertial = _rigid(recording, motion)
    return Excitation(
        top_speed=top,
        moving=share,
        slow_speed=slow_speed,
        slow=float(np.sum(slow)) / max(1, int(np.sum(moving))),
        slow_samples=int(np.sum(slow)),
        speeds=(float(low), float(high)),
        reversals=len(turns),
        one_way=is_one_way(motion),
        spacing=_spacing(turns),
        acceleration=float(np.quantile(np.abs(motion.a), 0.99)),
        mass=float(fit[0]) if np.isfinite(inertial) else np.nan,
        coulomb=float(fit[2]) if np.isfinite(inertial) else np.nan,
        inertial=inertial,
        turn_around=_turn_around(recording, motion, turns, fit),
    )


def reverses_quickly(recording: Recording) -> bool:
    """Tell whether the drive reverses within so few samples that a slow low-pass hides it."""
    return _spacing(reversals(recording, kinematics(recording))) < log_content.SPACING


def _spacing(turns: NDArray[np.intp]) -> float:
    return float(np.median(np.diff(turns))) if len(turns) > 1 else np.inf


def is_one_way(motion: Kinematics) -> bool:
    """Tell whether nearly all of the way, if there is any, has one direction."""
    ways = [float(np.sum(np.abs(motion.v[k * motion.v > motion.floor]))) for k in (1.0, -1.0)]
    return min(ways) < log_content.ONE_WAY * sum(ways)


def reversals(recording: Recording, motion: Kinematics) -> NDArray[np.intp]:
    """Return the samples (k,) at which the velocity reverses.

    Between two of them the drive moves by at least three encoder steps and a ten-thousandth of its
    range, so that noise at rest is not counted.
    """
    x = motion.x
    least = max(3 * recording.encoder_step, 1e-4 * float(np.ptp(x)))
    extremes = np.flatnonzero(np.diff(np.sign(motion.v))) + 1
    turns: list[int] = []
    last, way = 0, 0.0  # the farthest point since the last turn, and the direction to it
    for k in map(int, extremes):
        travel = x[k] - x[last]
        if way * travel >= 0 and (way or abs(travel) > least):
            last, way = k, way or float(np.sign(travel))
        elif abs(travel) > least:
            turns.append(last)
            last, way = k, -way
    if way and abs(x[-1] - x[last]) > least and (x[-1] - x[last]) * way < 0:
        turns.append(last)
    return np.array(turns, dtype=np.intp)


def _rigid(recording: Recording, motion: Kinematics) -> tuple[Array, float]:
    """Return F = m a + b v + F_c sign v + F_0 fitted while sliding, and the share of m."""
    drive = rigid(recording, motion)
    if drive is None or not np.all((scale := np.linalg.norm(drive.columns, axis=0)) > 0):
        return np.zeros(4), np.nan
    columns, force = drive.columns, drive.force[drive.used]
    fit = np.linalg.lstsq(columns / scale, force, rcond=None)[0] / scale
    whole = max(float(np.std(force)), 1e-300)
    return fit, abs(float(fit[0])) * float(np.std(columns[:, 0])) / whole


def _turn_around(
    recording: Recording, motion: Kinematics, turns: NDArray[np.intp], fit: Array
) -> TurnAround | None:
    """Return the reversal of friction between velocity reversals."""
    if recording.friction is not None:
        friction = smoothed(recording.friction, recording.T_s, motion.cutoff)
    elif recording.force is not None and fit.any():
        force = smoothed(recording.moving(recording.force), recording.T_s, motion.cutoff)
        friction = force - fit[0] * motion.a - fit[1] * motion.v - fit[3]
    else:
        return None
    if not np.any(np.abs(motion.v) > motion.floor):
        return None
    level = float(np.median(np.abs(friction[np.abs(motion.v) > motion.floor])))
    side = np.sign(friction @ motion.v)  # some log the force on the drive, some that of the drive
    found = []
    for begin, end in pairwise([*turns, len(friction)]):
        way = side * np.sign(motion.x[end - 1] - motion.x[begin])
        swing = way * friction[begin:end] / max(level, 1e-300)
        done = np.flatnonzero(swing > 2 * TURNED - 1)
        if swing[0] < 0 and len(done):
            found.append((abs(motion.x[begin + done[0]] - motion.x[begin]), done[0]))
    if not found:
        return None
    distance, samples = np.median(np.array(found), axis=0)
    step = recording.encoder_step
    counts = float(distance / step) if step else np.inf
    return TurnAround(float(distance), counts, float(samples), len(found))
