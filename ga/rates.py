"""How often a gene of a child mutates; an adaptive rate follows what succeeds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ga.arrays import Array
from ga.settings import Settings

SCATTER = 0.05
"""Standard deviation of the children's rates around the mean."""

LEARNING = 0.1
"""Share that a generation's successful rates have in the new mean."""


class MutationRate:
    """Draws a rate for each child, around a mean that moves to those that took a rival's place.

    Parameters
    ----------
    settings : gives the first mean; unless ``adaptive``, it is the rate of all children

    Source
    ------
    Zhang and Sanderson, JADE, IEEE Trans. Evolutionary Computation 13 (2009) 945, who adapt the
    crossover rate so. Doing both was no better here.
    """

    def __init__(self, settings: Settings) -> None:
        self._adaptive = settings.adaptive
        self._mean = settings.mutation_rate

    def draw(self, children: int, rng: np.random.Generator) -> Array:
        """Return the rates of so many children, shape (children, 1)."""
        if not self._adaptive:
            return np.full((children, 1), self._mean)
        return np.clip(self._mean + SCATTER * rng.standard_normal((children, 1)), 0.0, 1.0)

    def follow(self, rates: Array, successful: NDArray[np.bool_]) -> None:
        """Learn which of the children, shape (n,), succeeded with the rates drawn for them."""
        if self._adaptive and successful.any():
            self._mean += LEARNING * (float(rates[successful].mean()) - self._mean)
