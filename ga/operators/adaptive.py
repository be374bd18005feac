"""The adaptive probability of crossover: protect good parents, mix poor ones."""

from __future__ import annotations

import numpy as np

from stickslip.ga.arrays import Array


def crossover_probability(
    parents: Array, *, best: float, mean: float, k1: float, k2: float
) -> Array:
    """Return the probability that a pair of parents is crossed rather than copied.

    P_c = k1 (f_max - f') / (f_max - f_mean)   if f' >= f_mean
    P_c = k2                                   if f' <  f_mean

    When the whole generation is equally fit the fraction is 0/0. No parent then stands out to be
    protected, and the probability is k2.

    Parameters
    ----------
    parents : f', the larger fitness of each pair, shape (n,), finite
    best, mean : f_max and f_mean, fitness of the current generation
    k1, k2 : constants, 0 .. 1

    Returns
    -------
    ndarray, shape (n,), 0 .. max(k1, k2)

    Source
    ------
    Paper, (7), after Srinivas and Patnaik, IEEE Trans. SMC 24 (1994) 656.
    """
    if best <= mean:
        return np.full(parents.shape, k2)
    return np.where(parents >= mean, k1 * (best - parents) / (best - mean), k2)
