"""The force error that noise and the steps of encoder and force make."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_noise, position_of
from stickslip.identification.criteria.surrogate_controller import resimulated, surrogate_loop
from stickslip.identification.fitting.fit import Fit
from stickslip.logs import Recording
from stickslip.servo.measurement import Array, smoothed

BLOCKS = 40


def explained(
    inverse: InverseModel,
    fitted: Fit,
    fmus: Path,
    recording: Recording,
    gains: Mapping[str, float] | None = None,
) -> float:
    """Return it as a root mean square [N].

    A drive with the fitted values is simulated along the recording, with the encoder's steps and
    noise, and the force that the same values predict for it is compared with its own. In blocks of
    the recording the residual may have more at high frequencies, where a model's error is small:
    the median excess is noise of the force.

    Parameters
    ----------
    fmus : folder with compensator, drive and controller
    gains : of the known controller, whose loop is simulated; a surrogate follows the motion without
    """
    step = recording.encoder_step
    values, rng = fitted.parameters, np.random.default_rng(0)
    shown = position_noise(position_of(recording), step)
    noise = float(np.sqrt(max(shown**2 - step**2 / 12.0, 0.0)))
    if inverse.measures_friction:
        error = np.zeros_like(fitted.residual)
    else:
        with (
            surrogate_loop(inverse, values, fmus, recording)
            if gains is None
            else KnownLoop(fmus, recording, gains, encoder=True)
        ) as loop:
            offset = step * float(rng.random())
            error = resimulated(inverse, loop, fmus, recording, values, offset, noise)
    white = smoothed(rng.standard_normal(len(inverse.t)), inverse.T_s, inverse.cutoff)
    excess, unit = (
        float(np.median(blocks))
        for blocks in (
            _fast(fitted.residual, inverse) - _fast(error, inverse),
            _fast(white, inverse),
        )
    )
    of_force = max(excess, 0.0) / unit * float(np.mean(white**2))
    return float(np.sqrt(np.mean(error**2) + of_force))


def _fast(signal: Array, inverse: InverseModel) -> Array:
    """Return the mean square of what is above half the cut-off in each block."""
    fast = signal - smoothed(signal, inverse.T_s, 0.5 * inverse.cutoff)
    return np.array([np.mean(block**2) for block in np.array_split(fast, BLOCKS)])
