"""Motion of a rigid drive from its log, and how much later one signal shows than another."""

from __future__ import annotations  # scipy.interpolate is large, and loaded where it is used

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.logs.recording import Recording
from stickslip.servo.measurement import CUTOFF, Array, derivative, smoothed
from stickslip.thresholds import log_content, log_delay

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
    """Return what position or else velocity shows, low-passed [Hz] as the sampling allows."""
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
    motion = Kinematics(x, v, a, derivative(a, T_s), cutoff=cutoff, floor=floor)
    if recording.segments:  # what is between logs is no motion of the drive
        between = np.ones(len(v), dtype=bool)
        for log in recording.segments:
            between[log.begin : log.end] = False
        for signal in (motion.v, motion.a, motion.jerk):
            signal[between] = 0.0
    return motion


def sliding(motion: Kinematics, T_s: float, share: float = 0.1) -> NDArray[np.bool_]:
    """Return where (n,) it is faster than a share of its top speed, and not near slower motion."""
    slow = np.abs(motion.v) < share * np.max(np.abs(motion.v))
    reach = max(1, min(round(1.0 / (motion.cutoff * T_s)), (len(slow) - 1) // 2))
    near = np.convolve(slow, np.ones(2 * reach + 1), mode="same") > 0.5
    near[: 4 * reach] = near[len(near) - 4 * reach :] = True
    return np.asarray(~near)


@dataclass(frozen=True, eq=False)
class RigidDrive:
    """F = m a + b v + F_c sign v + F_0 while sliding."""

    used: NDArray[np.bool_]  # (n,) where the drive slides
    columns: Array  # (k, 4) of m, b, F_c and F_0
    force: Array  # (n,) through the low-pass of the motion [N]


def rigid(recording: Recording, motion: Kinematics) -> RigidDrive | None:
    """Return the equations of a rigid drive, None without a force or with few samples sliding."""
    used = sliding(motion, recording.T_s)
    if recording.force is None or used.sum() < log_content.SLIDING:
        return None
    columns = rigid_columns(motion, recording.T_s)[used]
    force = recording.moving(recording.force)
    return RigidDrive(used, columns, smoothed(force, recording.T_s, motion.cutoff))


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


DELAY_CUTOFF = 50.0  # low-pass of what is compared [Hz]
ROUNDS = 12
FARTHEST = 0.1  # delays beyond are not looked for [s]
TRIALS = 41  # delays that are tried at first
NOTHING = 1e-7  # share of a signal by which rounding alone changes it in one sample
AS_WELL = 3e-4
"""Share of the variance of a signal that may be left: the shortest of such delays is taken. A force
that switches is that of Coulomb friction alone, 10 to 30 ms early, too: 5e-8 to 1e-5 are left."""


@dataclass(frozen=True)
class Delay:
    """A delay [s], positive when the signal shows late; it may be larger if ``at_bound``."""

    value: float
    standard_error: float
    at_bound: bool = False

    def known(self, T_s: float) -> bool:
        """Whether it is known to a part of a sample."""
        return 2 * self.standard_error < log_delay.KNOWN * T_s

    def is_large(self, T_s: float) -> bool:
        """Whether it is surely more than that of a loop sampled at this period [s]."""
        return abs(self.value) - 2.0 * self.standard_error >= log_delay.REPORTED * T_s


def force_delay(recording: Recording) -> Delay | None:
    """Return the delay of the force behind the motion that it causes, None if unknown.

    While sliding, F(t + d) = m a + b v + F_c sign v + F_0. A remaining delay appears as a part of F
    proportional to the derivative of its inertial and viscous part, which is fitted and removed
    iteratively. Samples near reversals are left out: there presliding delays the force.
    """
    motion = kinematics(recording, DELAY_CUTOFF)
    if (drive := rigid(recording, motion)) is None:
        return None
    jerk, a = motion.jerk[drive.used], motion.a[drive.used]
    return _fitted(
        recording.t,
        drive.force,
        drive.used,
        drive.columns,
        slope=lambda fit: np.asarray(fit[0] * jerk + fit[1] * a),
    )


def signal_delay(t: Array, early: Array, late: Array) -> Delay | None:
    """Return how much later a signal shows that is else proportional to another.

    The time t (n,) is even [s]. Both signals (n,) went through the same low-pass; late(t + d) =
    gain * early(t) + offset.
    """
    T_s = float(t[1] - t[0])
    used = np.ones(len(t), dtype=bool)
    margin = max(2, len(t) // 50)
    used[:margin] = used[-margin:] = False
    if np.ptp(early) == 0 or np.ptp(late) == 0:
        return None
    rate = np.gradient(early, T_s)[used]
    base = np.column_stack([early[used], np.ones(int(used.sum()))])
    return _fitted(t, late, used, base, slope=lambda fit: np.asarray(fit[0] * rate))


def _fitted(
    t: Array, signal: Array, used: NDArray[np.bool_], base: Array, slope: Callable[[Array], Array]
) -> Delay | None:
    """Return the delay of a signal (n,) against columns (k, c), by Gauss-Newton.

    The first column is that of a mass or gain: where a signal switches, a negative one explains a
    wrong delay best. ``slope`` gives the derivative (k,) of what the columns fit by time, of the
    same smooth motion, so that noise in it weakens a step but not where the steps end.
    """
    from stickslip.catalog.parameters import covariance  # late: loads the stages

    T_s = float(t[1] - t[0])
    spline = scipy.interpolate.CubicSpline(t, signal)
    if (delay := _best_trial(spline, t[used], base)) is None:
        return None
    fit = np.linalg.lstsq(base, spline(t[used] + delay), rcond=None)[0]
    for _ in range(ROUNDS):
        shifted = spline(t[used] + delay)
        columns = np.column_stack([base, slope(np.asarray(fit))])
        scale = np.linalg.norm(columns, axis=0)
        if not np.all(scale > 0) or scale[-1] * T_s < NOTHING * np.linalg.norm(shifted):
            return None
        solution = np.linalg.lstsq(columns / scale, shifted, rcond=None)[0] / scale
        residual = shifted - columns @ solution
        fit, step = solution[:-1], -float(solution[-1])
        delay += step
        if not abs(delay) < FARTHEST:
            return Delay(float(np.copysign(FARTHEST, delay)), np.inf, at_bound=True)
        if abs(step) < 1e-4 * T_s:
            break
    if fit[0] <= 0.0:
        return None
    error = np.sqrt(covariance(columns / scale, residual)[-1, -1]) / scale[-1]
    return Delay(delay, float(error))


def _best_trial(signal: scipy.interpolate.CubicSpline, t: Array, base: Array) -> float | None:
    """Return the delay [s], of a few, with which columns (k, c) explain a signal at t (k,).

    None where the first column is of the wrong sign with each of them.
    """
    directions, triangle = basis(base)
    delays = np.linspace(-FARTHEST, FARTHEST, TRIALS)
    rests = np.full(TRIALS, np.inf)
    for k, delay in enumerate(delays):
        shifted = signal(np.clip(t + delay, signal.x[0], signal.x[-1]))
        along = directions.T @ shifted
        if np.linalg.solve(triangle, along)[0] > 0.0:
            rests[k] = shifted @ shifted - along @ along
    if np.isinf(rests).all():
        return None
    limit = max(rests.min(), AS_WELL * len(t) * float(np.var(signal(t))))
    k = int(min(np.flatnonzero(rests <= limit), key=lambda k: abs(delays[k])))
    while (near := max(k - 1, 0) + int(np.argmin(rests[max(k - 1, 0) : k + 2]))) != k:
        k = near
    return float(delays[k])


def sure_delay(recording: Recording, delay: Delay | None) -> Delay | None:
    """Return the delay of the force, as found, where it is sure and no loop explains it.

    A sampled loop and its amplifier account for less than two samples. Saturation and noise make
    delays, too; taking those out explains no more of the force.
    """
    T_s = recording.T_s
    if delay is None or not (delay.at_bound or delay.is_large(T_s)):
        return None
    return delay if _explains(recording, round(delay.value / T_s)) else None


def samples_late(recording: Recording) -> int:
    """Return by how many samples the force shows late for sure, 0 where it may be even more."""
    delay = sure_delay(recording, force_delay(recording))
    return 0 if delay is None or delay.at_bound else round(delay.value / recording.T_s)


def _explains(recording: Recording, samples: int) -> bool:
    """Tell whether a delay of so many samples explains much of the unexplained force, by a mass."""
    shown = aligned(recording, samples)
    if (drive := rigid(shown, kinematics(shown, DELAY_CUTOFF))) is None:
        return False
    mass = np.linalg.lstsq(drive.columns, drive.force[drive.used], rcond=None)[0][0]
    rest = left(drive.columns, drive.force[drive.used])
    return bool(mass > 0 and rest < log_delay.EXPLAINS * unexplained(recording))


def aligned(recording: Recording, samples: int) -> Recording:
    """Return a recording whose force shows so many samples earlier, cut where one signal lacks."""
    if recording.force is None or not samples:
        return recording
    n = len(recording.t) - abs(samples)
    late, other = max(samples, 0), max(-samples, 0)
    segments = tuple(replace(one, end=one.end - abs(samples)) for one in recording.segments)
    moved = recording.part(other, other + n)
    return replace(moved, force=recording.force[late : late + n], segments=segments)
