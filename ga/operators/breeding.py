"""Crossover and mutation, and how often each is used."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.ga.algorithms.settings import Settings
from stickslip.ga.problem.problem import Array


def fitness(costs: Array) -> Array:
    """Return the fitness J = 1 / cost of candidates (n,), as a fraction of the best one's.

    Selection and the crossover probability (7) depend on ratios of J only, and a fraction stays
    finite when the best cost is 0. A failed candidate, whose cost is inf, has 0, unless all failed.
    Source: paper, (6), where the cost is the sum of (v - v_r)^2.
    """
    best = float(costs.min())
    if best == 0 or np.isinf(best):
        return np.where(costs == best, 1.0, 0.0)
    return np.divide(best, costs)


def crossover_probability(
    parents: Array, *, best: float, mean: float, k1: float, k2: float
) -> Array:
    """Return the probability that a pair of parents is crossed rather than copied, (n,).

    P_c = k1 (f_max - f') / (f_max - f_mean) if f' >= f_mean, else k2. When the whole generation is
    equally fit the fraction is 0/0. No parent is then better than the others, and the probability
    is k2.

    Parameters
    ----------
    parents : f', the larger fitness of each pair, shape (n,), finite
    best, mean : f_max and f_mean, fitness of the current generation
    k1, k2 : constants, 0 .. 1

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
    Source: paper, Step 4, parts 1 and 2.
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
    is one parent; the children are in the order of these places. Source: Storn and Price, J. Global
    Optimization 11 (1997) 341, here below an elite that is kept.
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
Mutation = Callable[[Array, Array, Array, np.random.Generator], Array]
"""(children (m, k); strings of the population (n, k); rates (m, 1); rng) -> children (m, k)"""


def uniform(children: Array, strings: Array, rates: Array, rng: np.random.Generator) -> Array:
    """Give a mutated gene any value of its range (paper, Step 4, part 3)."""
    del strings  # wherever the population is
    mutated = rng.random(children.shape) < rates
    return np.where(mutated, rng.random(children.shape), children)


def spread(children: Array, strings: Array, rates: Array, rng: np.random.Generator) -> Array:
    """Move a mutated gene by about twice the population's standard deviation in that gene.

    The change is wide while the population is scattered and fine once it has closed in, so no
    schedule has to be guessed.
    """
    mutated = rng.random(children.shape) < rates
    change = 2 * strings.std(axis=0) * rng.standard_normal(children.shape)
    return np.where(mutated, children + change, children)


MUTATIONS: dict[str, Mutation] = {"uniform": uniform, "spread": spread}
SCATTER = 0.05  # standard deviation of the children's rates around the mean
LEARNING = 0.1  # share that a generation's successful rates have in the new mean


class MutationRate:
    """Draws a rate for each child, around a mean that moves to those that took a rival's place.

    Unless the settings are ``adaptive``, their rate is that of all children. Source: Zhang and
    Sanderson, JADE, IEEE Trans. Evolutionary Computation 13 (2009) 945, who adapt the crossover
    rate so. Doing both was no better here.
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


LEAST = 0.02  # share of the children that every way to breed them keeps
MEMORY = 0.9
"""Weight of what was learned before, each time that a generation improves on the best cost."""


class Shares:
    """Draws in which of several ways each child is bred: in those that improve the best cost more.

    ``first`` is the share of each way in what is expected at first, relative to the others.
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
