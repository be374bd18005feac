"""The cheapest candidates seen, to fit a quadratic to."""

from __future__ import annotations

import numpy as np

from ga.arrays import Array
from ga.quadratic import bottom


class Archive:
    """Keeps so many of the cheapest candidates.

    Parameters
    ----------
    size : how many
    genes : k
    """

    def __init__(self, size: int, genes: int) -> None:
        self._size = size
        self._strings = np.empty((0, genes))
        self._costs = np.empty(0)

    def add(self, strings: Array, costs: Array) -> None:
        """Take candidates, shape (n, k), and their costs, shape (n,)."""
        all_costs = np.concatenate([self._costs, costs])
        order = np.argsort(all_costs, kind="stable")[: self._size]
        self._strings = np.vstack([self._strings, strings])[order]
        self._costs = all_costs[order]

    def bottom(self) -> Array | None:
        """Return where a quadratic through them is lowest, shape (k,), if that can be said."""
        return bottom(self._strings, self._costs)
