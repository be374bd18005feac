"""The first generation."""

from __future__ import annotations

import numpy as np

from stickslip.ga.algorithms.settings import Settings
from stickslip.ga.arrays import Array


def first_generation(start: Array, settings: Settings, rng: np.random.Generator) -> Array:
    """Draw the strings of the first generation: the start, some around it, the rest anywhere.

    Parameters
    ----------
    start : string of the identified values, shape (k,)

    Returns
    -------
    ndarray, shape (population, k); may leave [0, 1] around the start

    Source
    ------
    Paper, Step 1.
    """
    others = settings.population - 1
    near = round(settings.near_share * others)
    around = start + settings.near_spread * rng.standard_normal((near, start.size))
    anywhere = rng.random((others - near, start.size))
    return np.vstack([start, around, anywhere])
