"""How often a gene mutates, and how often children are bred in which way, after what succeeds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.ga.algorithms.settings import Settings
from stickslip.ga.arrays import Array

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


LEAST = 0.02
"""Share of the children that every way to breed them keeps."""

MEMORY = 0.9
"""Weight of what was learned before, each time that a generation improves on the best cost."""


class Shares:
    """Draws in which of several ways each child is bred: in those that improve the best cost more.

    Parameters
    ----------
    first : share of each way in what is expected at first, relative to the others
    """

    def __init__(self, first: Sequence[float]) -> None:
        self._won, self._tried = np.array(first, dtype=float), np.ones(len(first))

    @property
    def shares(self) -> Array:
        """Probability of each way, shape (ways,)."""
        rates = self._won / self._tried
        return np.asarray(LEAST + (1 - LEAST * len(rates)) * rates / rates.sum())

    def draw(self, children: int, rng: np.random.Generator) -> NDArray[np.int_]:
        """Return the way of each of so many children."""
        return rng.choice(len(self._tried), size=children, p=self.shares)

    def follow(self, ways: NDArray[np.int_], better: NDArray[np.bool_]) -> None:
        """Learn which children, shape (n,), of these ways cost less than the best one before."""
        if better.any():
            won, tried = (np.bincount(w, minlength=len(self._won)) for w in (ways[better], ways))
            self._won = MEMORY * self._won + won / won.sum()
            self._tried = MEMORY * self._tried + tried / tried.sum()
