"""The force error that noise and the steps of encoder and force make."""

from __future__ import annotations

import numpy as np

from stickslip.catalog.space import Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.motion import position_noise, position_of, smooth_motion
from stickslip.identification.fitting.fit import Fit
from stickslip.logs import Recording
from stickslip.servo.measurement import Array, smoothed


def explained(inverse: InverseModel, fitted: Fit, recording: Recording) -> float:
    """Return it as a root mean square [N].

    The smooth motion is logged again with the encoder's steps and noise; the force that the fitted
    values predict for it differs by the error from the encoder. What the residual has above half
    the cut-off of the low-pass, where a model's error is small, and the encoder does not make, is
    taken for white noise of the force.
    """
    values = fitted.parameters
    rng = np.random.default_rng(0)
    error = _from_encoder(inverse, values, recording, rng)[inverse.used]
    fast, own = (_fast(signal, inverse) for signal in (fitted.residual, error))
    white = _fast(
        smoothed(rng.standard_normal(len(inverse.t)), inverse.T_s, inverse.cutoff), inverse
    )
    whole = float(
        np.mean(smoothed(rng.standard_normal(len(inverse.t)), inverse.T_s, inverse.cutoff) ** 2)
    )
    noise = max(fast - own, 0.0) / white * whole
    return float(np.sqrt(np.mean(error**2) + noise))


def _from_encoder(
    inverse: InverseModel, values: Values, recording: Recording, rng: np.random.Generator
) -> Array:
    """Return the error (n,) [N] of the predicted force from the encoder."""
    step = recording.encoder_step
    position = position_of(recording)
    spread = np.sqrt(max(position_noise(position, step) ** 2 - step**2 / 12.0, 0.0))
    shown = smoothed(position, inverse.T_s, inverse.cutoff)
    shown = shown + spread * rng.standard_normal(len(shown))
    if step:
        offset = step * rng.random()
        shown = step * np.round((shown + offset) / step) - offset
    return inverse.predicted(
        values, smooth_motion(shown, inverse.T_s, inverse.cutoff)
    ) - inverse.predicted(values)


def _fast(signal: Array, inverse: InverseModel) -> float:
    """Return the median over blocks of the mean square of what is above half the cut-off."""
    fast = signal - smoothed(signal, inverse.T_s, 0.5 * inverse.cutoff)
    return float(np.median([np.mean(block**2) for block in np.array_split(fast, 40)]))
