"""The bias of the inverse model, estimated with a surrogate for the unknown controller.

Encoder quantisation, the low-pass and sampling bias the fit of the inverse model. A simulated drive
with the fitted values follows the recorded motion under a surrogate controller, is recorded with
the same encoder, and is fitted by one Gauss step; the difference from the known values is
subtracted.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from stickslip.catalog.space import Values
from stickslip.identification.controller.initial_state import HELD
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.fitting.fit import Fit, linearised
from stickslip.logs import Recording
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import loop_fit

RUNS = 8
ROUNDS = 3
BANDWIDTH = 0.02  # bandwidth of the surrogate's velocity loop, as a share of the sample rate
LOOSE = 0.5  # standard error of a coordinate above which it is not corrected


def coarse(inverse: InverseModel, recording: Recording) -> bool:
    """Return whether encoder quantisation is coarse enough to require a correction.

    Where it is not, the bootstrap samples differ mainly by the surrogate controller, and a
    correction made the result for a measured axis (EMPS) worse.
    """
    top = float(np.quantile(np.abs(inverse.motion.v), 0.99))
    return recording.encoder_step / inverse.T_s > loop_fit.COARSE * top


def correct_inverse(inverse: InverseModel, fitted: Fit, seed: int) -> tuple[Fit, Array, bool]:
    """Return the fit without its bias, and the bias (k,) that was subtracted from its coordinates.

    The last value is whether the residuals of bootstrap samples are about as large as those of the
    recording. If not, the surrogate excites the drive differently from its real controller, and
    the bias is not valid.
    """
    space = fitted.space
    rng = np.random.default_rng(seed)
    at, ratios = fitted, []
    loose = np.sqrt(np.diag(fitted.covariance)) > LOOSE
    with surrogate_loop(inverse, fitted.parameters) as loop:
        for _ in range(ROUNDS):
            drawn = inverse.recording.encoder_step * rng.random(RUNS)
            left = loop.each(partial(resimulated, inverse, loop, at.parameters), drawn)
            ratios.append(float(np.mean(np.square(left))) / at.variance)
            own = at.step() - np.mean([at.shift(one) for one in left], axis=0)
            q = at.q + np.where(loose, 0.0, own)
            q = space.inside(q)
            at = linearised(inverse.over(space), q, fitted.noise)
    return replace(at, covariance=fitted.covariance), fitted.q - at.q, is_alike(ratios[0])


def is_alike(ratio: float) -> bool:
    """Tell whether a ratio of mean squares, resimulated to recorded, is that of a like loop."""
    return 1.0 / loop_fit.ALIKE < ratio < loop_fit.ALIKE


def surrogate_loop(inverse: InverseModel, values: Values) -> KnownLoop:
    """Return a loop in which the drive with these values follows the recorded motion."""
    recording = inverse.recording
    path = smoothed(position_of(recording), inverse.T_s, inverse.cutoff)
    led = replace(recording, position_command=path, velocity_command=inverse.motion.v)
    led = replace(led, added_force=None, added_velocity=None)  # the motion shows them
    gains = _gains(values, inverse.T_s)
    return KnownLoop(inverse.fmus, led, gains, encoder=True, workers=inverse.workers)


def _gains(values: Values, T_s: float) -> dict[str, float]:
    """Return a cascade for the fitted mass whose integral starts at the constant force."""
    rate = 2.0 * np.pi * BANDWIDTH / T_s  # [rad/s]
    K_p = rate * values["m"]
    gains = {"K_p": K_p, "K_i": K_p * rate / 8.0, "K_x": rate / 4.0, "tau_f": T_s, "T_s": T_s}
    return {**gains, HELD: values["F_0"]}


def resimulated(
    inverse: InverseModel, loop: KnownLoop, values: Values, offset: float, noise: float = 0.0
) -> Array:
    """Return the residual (k,) [N] of the drive with these values, simulated and recorded again.

    Parameters
    ----------
    offset : displacement of the drive, and so of the encoder's steps [m]
    noise : standard deviation of white noise on the position [m]
    """
    recording = inverse.recording
    start = position_of(recording)[0] + offset
    further = {"candidate.x": start, "candidate.noise_x": max(noise, 1e-9 * abs(offset))}
    result = loop.run({**values, "delay": 0.0}, further)
    # The drive's output at the end of a sample is the force held over it; the controller adds the
    # constant force, so the output contains it.
    late = inverse.t + values["delay"] + 0.5 * inverse.T_s
    again = replace(
        recording,
        position=result["candidate.x_enc"],
        force=np.interp(late, inverse.t, result["candidate.F_m"]) + values["F_0"],
    )
    with InverseModel(inverse.fmus, again, inverse.cutoff, law=inverse.space.law) as copy:
        return copy.residual(values)
