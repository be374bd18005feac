"""Fitness: the inverse of the cost."""

from __future__ import annotations

import numpy as np

from stickslip.ga.arrays import Array


def fitness(costs: Array) -> Array:
    """Return the fitness J = 1 / cost of every candidate, as a fraction of the best one's.

    Selection and the crossover probability (7) depend on ratios of J only, and a fraction stays
    finite when the best cost is 0.

    Parameters
    ----------
    costs : shape (n,), 0 .. inf

    Returns
    -------
    ndarray, shape (n,), 0 .. 1. A failed candidate, whose cost is inf, has 0, unless all failed.

    Source
    ------
    Paper, (6), where the cost is the sum of (v - v_r)^2.
    """
    best = float(costs.min())
    if best == 0 or np.isinf(best):
        return np.where(costs == best, 1.0, 0.0)
    return np.divide(best, costs)
