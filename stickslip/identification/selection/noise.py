"""The force error that noise and the steps of encoder and force make."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.catalog.space import Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_noise, position_of
from stickslip.identification.criteria.surrogate_controller import resimulated, surrogate_loop
from stickslip.servo.measurement import Array, smoothed

BLOCKS = 40


def explained(inverse: InverseModel, residual: Array, encoder: Array) -> float:
    """Return it as a root mean square [N].

    In blocks of the recording the residual may have more at high frequencies, where a model's error
    is small, than the encoder makes: the median excess is noise of the force.

    Parameters
    ----------
    residual : what a fit leaves of the force (k,) [N]
    encoder : what ``encoder_error`` returns for it (k,) [N]
    """
    white = np.random.default_rng(1).standard_normal(len(inverse.t))
    white = smoothed(white, inverse.T_s, inverse.cutoff)
    excess, unit = (
        float(np.median(blocks))
        for blocks in (_fast(residual, inverse) - _fast(encoder, inverse), _fast(white, inverse))
    )
    of_force = max(excess, 0.0) / unit * float(np.mean(white**2))
    return float(np.sqrt(np.mean(encoder**2) + of_force))


def encoder_error(
    inverse: InverseModel, values: Values, gains: Mapping[str, float] | None = None
) -> Array:
    """Return the error of the inverse model (k,) [N] in a recording of exactly this drive.

    The drive is simulated along the recording, with the encoder's steps and noise, and the force
    that its values predict is compared with its own.

    Parameters
    ----------
    values : of the drive by name
    gains : of the known controller. Its loop is simulated beside one with a surrogate that follows
        the motion: a loop with wrong values may oscillate, and the smaller error is returned
    """
    if inverse.measures_friction:
        return np.zeros_like(inverse.t[inverse.used])
    step = inverse.recording.encoder_step
    shown = position_noise(position_of(inverse.recording), step)
    noise = float(np.sqrt(max(shown**2 - step**2 / 12.0, 0.0)))
    offset = step * float(np.random.default_rng(0).random())
    errors = []
    with surrogate_loop(inverse, values) as loop:
        errors.append(resimulated(inverse, loop, values, offset, noise=noise))
    if gains is not None:
        with KnownLoop(inverse.fmus, inverse.recording, gains, encoder=True) as loop:
            errors.append(resimulated(inverse, loop, values, offset, noise=noise))
    least = min(errors, key=lambda error: float(np.mean(error**2)))
    if np.mean(least**2) > np.mean(inverse.force[inverse.used] ** 2):  # no such drive moves so
        return np.zeros_like(least)
    return least


def _fast(signal: Array, inverse: InverseModel) -> Array:
    """Return the mean square of what is above half the cut-off in each block."""
    fast = signal - smoothed(signal, inverse.T_s, 0.5 * inverse.cutoff)
    return np.array([np.mean(block**2) for block in np.array_split(fast, BLOCKS)])
