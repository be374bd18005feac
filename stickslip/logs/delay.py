"""How much later one signal of a log shows than another, finer than its samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.logs.motion import basis, kinematics, left, rigid, unexplained
from stickslip.logs.recording import Recording
from stickslip.servo.measurement import Array
from stickslip.thresholds import log_delay

CUTOFF = 50.0  # Low-pass of what is compared [Hz]
ROUNDS = 12
FARTHEST = 0.1  # delays beyond are not looked for [s]
TRIALS = 41  # delays that are tried at first
NOTHING = 1e-7
"""Share of a signal by which it changes in one sample, where nothing but rounding changes it."""
AS_WELL = 3e-4
"""Share of the variance of a signal that may be left: the shortest of such delays is taken. A force
that switches is that of Coulomb friction alone, 10 to 30 ms early, too: 5e-8 to 1e-5 are left."""


@dataclass(frozen=True)
class Delay:
    """A delay [s], positive when the signal shows late, and its standard error.

    ``at_bound`` tells that it may be larger: the search ends there.
    """

    value: float
    standard_error: float
    at_bound: bool = False

    def known(self, T_s: float) -> bool:
        """Whether it is known to a part of a sample."""
        return 2 * self.standard_error < log_delay.KNOWN * T_s

    def is_large(self, T_s: float) -> bool:
        """Whether it is more than that of a loop sampled at this period [s]."""
        return abs(self.value) >= log_delay.REPORTED * T_s


def force_delay(recording: Recording) -> Delay | None:
    """Return the delay of the force behind the motion that it causes, None if unknown.

    While sliding, F(t + d) = m a + b v + F_c sign v + F_0. A remaining delay appears as a part of F
    proportional to the derivative of its inertial and viscous part, which is fitted and removed
    iteratively. Samples near reversals are left out: there presliding delays the force.
    """
    motion = kinematics(recording, CUTOFF)
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

    Parameters
    ----------
    t : (n,) even [s]
    early, late : (n,) through the same low-pass; late(t + d) = gain * early(t) + offset
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

    The first column is that of a mass or gain: where a signal switches, a wrong delay may explain
    it best, by a negative one, and is not looked at.

    ``slope`` gives the derivative (k,) of what the columns fit by time. It is the same smooth
    motion that the delay moves along, so noise in it weakens a step but not where the steps end.
    """
    from stickslip.catalog.estimate import covariance  # late: loads the stages

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


def samples_late(recording: Recording) -> int:
    """Return by how many samples the force shows late, where that is sure and no loop explains it.

    A sampled loop and its amplifier account for less than two samples. Saturation and noise make
    delays, too; taking those out explains no more of the force.
    """
    delay = force_delay(recording)
    if delay is None or delay.at_bound or not delay.is_large(recording.T_s):
        return 0
    samples = round(delay.value / recording.T_s)
    return samples if _explains(recording, samples) else 0


def late_beyond(recording: Recording) -> float:
    """Return the largest delay [s] that is looked for, with its sign, if the force has more; or 0.

    It has where that delay explains the force, and a smaller one explains less.
    """
    delay = force_delay(recording)
    if delay is None or not delay.at_bound:
        return 0.0
    return delay.value if _explains(recording, round(delay.value / recording.T_s)) else 0.0


def _explains(recording: Recording, samples: int) -> bool:
    """Tell whether a delay of so many samples explains much of the unexplained force, by a mass.

    Where the force switches, a wrong delay explains it best, by a negative mass.
    """
    shown = aligned(recording, samples)
    if (drive := rigid(shown, kinematics(shown, CUTOFF))) is None:
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
    cut: dict[str, Any] = {
        field.name: value[other : other + n]
        for field in fields(recording)
        if isinstance(value := getattr(recording, field.name), np.ndarray)
    }
    cut |= {"t": recording.t[:n], "force": recording.force[late : late + n]}
    return replace(recording, **cut)
