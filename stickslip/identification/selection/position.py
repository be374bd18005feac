"""Force that depends on position and direction: ripple, friction along the travel, asymmetry."""

from __future__ import annotations

import numpy as np

from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.selection.folds import folds
from stickslip.identification.selection.mismatch import Cause
from stickslip.identification.selection.prediction import memory
from stickslip.logs import Recording
from stickslip.servo.measurement import Array

PLACES = 60  # places along the travel; the force is linear between them
RIDGE = 10.0  # samples of no force that each place counts in addition
THIN = 4


def along_the_travel(inverse: InverseModel, recording: Recording, residual: Array) -> Cause:
    """Return the cause, tested on a held-out residual (k,) [N].

    A function of the position for each direction is fitted to it, and predicts in turn the blocks
    that it was not fitted to.
    """
    every = slice(None, None, THIN)
    position = position_of(recording)[inverse.used][every]
    ahead = np.sign(inverse.motion.v[inverse.used][every])
    residual = residual[every]
    place = (position - position.min()) / max(float(np.ptp(position)), 1e-300) * (PLACES - 1)
    hats = np.maximum(1.0 - np.abs(place[:, np.newaxis] - np.arange(PLACES)), 0.0)
    rows = np.hstack([hats * (ahead[:, np.newaxis] > 0.0), hats * (ahead[:, np.newaxis] < 0.0)])
    left = residual.copy()
    for fold in folds(len(residual), memory(inverse) // THIN):
        fitted = rows[fold.fitted]
        square = fitted.T @ fitted + RIDGE * np.eye(2 * PLACES)
        force = np.linalg.solve(square, fitted.T @ residual[fold.fitted])
        left[fold.held_out] -= rows[fold.held_out] @ force
    return Cause(
        "a force that depends on position and direction",
        float(np.sqrt(np.mean(left**2))),
        "the friction learned is the mean along the travel",
    )
