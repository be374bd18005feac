"""Velocity and acceleration that a recording shows, and the rigid part of its force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.logs.recording import Recording
from stickslip.servo.measurement import CUTOFF, Array, derivative, smoothed
from stickslip.thresholds import log_content

FASTEST = 0.1  # Low-pass cutoff at most, in sampling frequencies


@dataclass(frozen=True, eq=False)
class Kinematics:
    """All signals through one zero-phase low-pass, so that they stay in step."""

    x: Array  # (n,) [m]
    v: Array  # (n,) [m/s]
    a: Array  # (n,) [m/s^2]
    jerk: Array  # (n,) [m/s^3]
    cutoff: float  # of the low-pass [Hz]
    floor: float  # velocity below which the steps of the encoder hide motion [m/s]


def kinematics(recording: Recording, cutoff: float = CUTOFF) -> Kinematics:
    """Return what the position, or else the velocity, shows of the motion.

    Parameters
    ----------
    recording : with a position or a velocity
    cutoff : of the low-pass [Hz], less where the sampling is slow
    """
    T_s = recording.T_s
    cutoff = min(cutoff, FASTEST / T_s)
    if recording.position is not None:
        x = smoothed(recording.position, T_s, cutoff)
        v = derivative(x, T_s)
    elif recording.velocity is not None:
        v = smoothed(recording.velocity, T_s, cutoff)
        x = np.cumsum(v) * T_s
    else:
        x = v = np.zeros_like(recording.t)
    a = derivative(v, T_s)
    # Rounding to steps is noise of variance step^2 / 12, spread evenly up to half the sampling
    # frequency; differentiated and cut off it has this standard deviation.
    noise = 2 * np.pi * recording.encoder_step * np.sqrt(cutoff**3 * T_s / 18)
    floor = max(3 * float(noise), 1e-4 * float(np.max(np.abs(v))))
    return Kinematics(x, v, a, derivative(a, T_s), cutoff=cutoff, floor=floor)


def sliding(motion: Kinematics, T_s: float, share: float = 0.1) -> NDArray[np.bool_]:
    """Return where (n,) the drive slides fast, farther from slow motion than the low-pass smears.

    Parameters
    ----------
    motion : of a recording
    T_s : its sample period [s]
    share : of the top speed that is fast
    """
    slow = np.abs(motion.v) < share * np.max(np.abs(motion.v))
    reach = max(1, min(round(1.0 / (motion.cutoff * T_s)), (len(slow) - 1) // 2))
    near = np.convolve(slow, np.ones(2 * reach + 1), mode="same") > 0.5
    near[: 4 * reach] = near[len(near) - 4 * reach :] = True
    return np.asarray(~near)


@dataclass(frozen=True, eq=False)
class Rigid:
    """F = m a + b v + F_c sign v + F_0 while sliding."""

    used: NDArray[np.bool_]  # (n,) where the drive slides
    columns: Array  # (k, 4) of m, b, F_c and F_0
    force: Array  # (n,) through the low-pass of the motion [N]


def rigid(recording: Recording, motion: Kinematics) -> Rigid | None:
    """Return the equations of a rigid drive, None without a force or with few samples sliding."""
    used = sliding(motion, recording.T_s)
    if recording.force is None or used.sum() < log_content.SLIDING:
        return None
    columns = rigid_columns(motion, recording.T_s)[used]
    return Rigid(used, columns, smoothed(recording.force, recording.T_s, motion.cutoff))


def rigid_columns(motion: Kinematics, T_s: float) -> Array:
    """Return what m, b, F_c and F_0 multiply (n, 4), all through the low-pass of the motion."""
    direction = smoothed(np.sign(motion.v), T_s, motion.cutoff)
    return np.column_stack([motion.a, motion.v, direction, np.ones_like(motion.v)])


def unexplained(recording: Recording) -> float:
    """Return the sum of squares [N^2] of the force that a rigid drive leaves, NaN if unknown."""
    drive = rigid(recording, kinematics(recording))
    return np.nan if drive is None else left(drive.columns, drive.force[drive.used])


def left(columns: Array, force: Array) -> float:
    """Return the sum of squares [N^2] that columns (k, c) leave of a force (k,)."""
    directions, _ = basis(columns)
    rest = force - directions @ (directions.T @ force)
    return float(rest @ rest)


def basis(columns: Array) -> tuple[Array, Array]:
    """Return the QR factors (k, r), (r, r) of columns (k, c) scaled to length 1, zeros left out."""
    scale = np.linalg.norm(columns, axis=0)
    return np.linalg.qr(columns[:, scale > 0.0] / scale[scale > 0.0])
