"""Predictions of friction laws with given errors."""

import numpy as np

from stickslip.catalog.parameters import friction_law
from stickslip.identification.selection import Candidate, Prediction
from stickslip.identification.selection.folds import Moving

BLOCKS = 40


def predicted(law, error, *, is_level=False, shown=("F_s",), spread=0.2, seed=0, fails=False):
    """Return a prediction whose error varies from block to block."""
    rng = np.random.default_rng(seed)
    squares = error**2 * np.exp(spread * rng.standard_normal(BLOCKS))
    squares *= error**2 / squares.mean()
    candidate = Candidate(friction_law(law), is_level=is_level)
    shown = () if is_level else shown
    moving = Moving(error, 0.5 * error, fails)
    return Prediction(candidate, {}, {}, error, error / 6.0, 0.1, squares, shown, moving)
