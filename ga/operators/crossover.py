"""Crossover: fitness, adaptive probability, and a child for every place outside the elite."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stickslip.ga.algorithms.settings import Settings
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


def crossover_probability(
    parents: Array, *, best: float, mean: float, k1: float, k2: float
) -> Array:
    """Return the probability that a pair of parents is crossed rather than copied.

    P_c = k1 (f_max - f') / (f_max - f_mean)   if f' >= f_mean
    P_c = k2                                   if f' <  f_mean

    When the whole generation is equally fit the fraction is 0/0. No parent is then better
    than the others, and the probability is k2.

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


Crossover = Callable[[Array, Array, Settings, np.random.Generator], Array]
"""(strings (n, k), best first; costs (n,), ...) -> children (n - elites, k)"""


def arithmetic(strings: Array, costs: Array, settings: Settings, rng: np.random.Generator) -> Array:
    """Return two weighted means of each pair of parents, or copies where it is not crossed.

    Parents are drawn in proportion to their fitness and crossed with the probability P_c of (7).

    Source
    ------
    Paper, Step 4, parts 1 and 2.
    """
    children = len(strings) - settings.elites
    pairs = (children + 1) // 2
    J = fitness(costs)
    parents = rng.choice(len(strings), size=(pairs, 2), p=J / J.sum())
    P_c = crossover_probability(
        J[parents].max(axis=1), best=J.max(), mean=J.mean(), k1=settings.k1, k2=settings.k2
    )
    crossed = rng.random(pairs) < P_c
    weight = np.where(crossed, rng.random(pairs), 1.0)[:, np.newaxis]
    first, second = strings[parents[:, 0]], strings[parents[:, 1]]
    mixed = [weight * first + (1 - weight) * second, weight * second + (1 - weight) * first]
    return np.stack(mixed, axis=1).reshape(2 * pairs, -1)[:children]


TO_BEST = 0.7
"""Probability that a differential child starts from the best candidate, not from a random one."""

STRETCH = (0.5, 1.0)
"""Range of the factor that a differential child applies to the difference of two others."""


def differential(
    strings: Array, costs: Array, settings: Settings, rng: np.random.Generator
) -> Array:
    """Move a good candidate by the difference of two others, and mix it with the parent by gene.

    The differences carry the size, shape and tilt of the population, so the steps follow a bent and
    narrow valley of the cost and shrink as the population closes in. Each place outside the elite
    is one parent; the children are in the order of these places.

    Source
    ------
    Storn and Price, J. Global Optimization 11 (1997) 341, here below an elite that is kept.
    """
    del costs  # the order of the strings says all that is needed
    children = []
    for place in range(settings.elites, len(strings)):
        others = np.delete(np.arange(len(strings)), place)
        plus, minus, random = rng.choice(others, size=3, replace=False)
        origin = 0 if rng.random() < TO_BEST else random
        moved = strings[origin] + rng.uniform(*STRETCH) * (strings[plus] - strings[minus])
        crossed = rng.random(strings.shape[1]) < settings.crossover_rate
        children.append(np.where(crossed, moved, strings[place]))
    return np.array(children)


CROSSOVERS: dict[str, Crossover] = {"arithmetic": arithmetic, "differential": differential}
