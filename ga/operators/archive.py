"""The candidates seen, the cheapest first, for models of the cost to be fitted to."""

from __future__ import annotations

import numpy as np

from stickslip.ga.arrays import Array

MOST = 4096
"""Candidates kept."""


class Archive:
    """Keeps the cheapest candidates on k genes.

    Attributes
    ----------
    strings : the cheapest first, shape (n, k)
    costs : shape (n,), 0 .. inf
    """

    def __init__(self, genes: int) -> None:
        self.strings = np.empty((0, genes))
        self.costs = np.empty(0)

    def add(self, strings: Array, costs: Array) -> None:
        """Take candidates, shape (n, k), and their costs, shape (n,)."""
        all_costs = np.concatenate([self.costs, costs])
        order = np.argsort(all_costs, kind="stable")[:MOST]
        self.strings = np.vstack([self.strings, strings])[order]
        self.costs = all_costs[order]
