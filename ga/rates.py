"""How often a child is crossed and mutated, gene by gene; adaptive rates follow what succeeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ga.arrays import Array
from ga.settings import Settings

SCATTER = {"crossover": 0.1, "mutation": 0.05}
"""Standard deviation of the children's rates around the mean."""

LEARNING = 0.1
"""Share that a generation's successful rates have in the new mean."""


@dataclass(frozen=True)
class Rates:
    """Probabilities for a gene of each of n children, each of shape (n, 1)."""

    crossover: Array
    mutation: Array


class AdaptiveRates:
    """Draws rates around means that move to those of children that took their rival's place.

    Parameters
    ----------
    settings : gives the first means; unless ``adaptive``, these are the rates of all children

    Source
    ------
    Zhang and Sanderson, JADE, IEEE Trans. Evolutionary Computation 13 (2009) 945, for crossover.
    """

    def __init__(self, settings: Settings) -> None:
        self._adaptive = settings.adaptive
        self._means = {"crossover": settings.crossover_rate, "mutation": settings.mutation_rate}

    def draw(self, children: int, rng: np.random.Generator) -> Rates:
        """Return the rates of so many children."""
        drawn = {
            name: np.clip(mean + SCATTER[name] * rng.standard_normal((children, 1)), 0.0, 1.0)
            if self._adaptive
            else np.full((children, 1), mean)
            for name, mean in self._means.items()
        }
        return Rates(**drawn)

    def follow(self, rates: Rates, successful: NDArray[np.bool_]) -> None:
        """Learn which of the children, shape (n,), succeeded with the rates drawn for them."""
        if self._adaptive and successful.any():
            for name, mean in self._means.items():
                good = float(getattr(rates, name)[successful].mean())
                self._means[name] = mean + LEARNING * (good - mean)
