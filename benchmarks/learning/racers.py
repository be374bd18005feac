"""Who races: ours, and the same problem given to scipy.

Both search the logarithms of the genes, or the genes where those are linear, from the same start,
keep constraints by the same repair and have the same budget.
"""

import contextlib
import warnings
from collections.abc import Callable

import numpy as np
from scipy.optimize import differential_evolution

from stickslip import ga
from stickslip.ga.problem.problem import Encoding

Cost = Callable[[np.ndarray], float]
Racer = Callable[[Cost, ga.Problem, int, int], None]
"""(cost of values (k,), problem, seed, budget): evaluates until it raises `BudgetEnd` or is done"""


class BudgetEnd(Exception):
    """The budget is used up."""


class Clock:
    """Counts a racer's evaluations and keeps the least cost."""

    def __init__(self, evaluate: Cost, budget: int) -> None:
        self._cost, self._budget = evaluate, budget
        self.evaluations, self.best = 0, np.inf

    def __call__(self, values: np.ndarray) -> float:
        if self.evaluations == self._budget:
            raise BudgetEnd
        self.evaluations += 1
        found = self._cost(values)
        self.best = min(found, self.best)
        return found


def race_one(racer: Racer, evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> Clock:
    """Let one of them search a problem, and return what it found."""
    clock = Clock(evaluate, budget)
    with warnings.catch_warnings(), contextlib.suppress(BudgetEnd):
        warnings.simplefilter("ignore")  # of the other
        racer(clock, given, seed, budget)
    return clock


def ours(evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> None:
    """Search by the default algorithm."""
    ga.learn(ga.optimiser("default", given, ga.Limits(evaluations=budget), seed), evaluate)


def scipy_de(evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> None:
    """Search by scipy's differential evolution with a population of two for each gene."""
    encoding = Encoding.of(given)

    def cost(string: np.ndarray) -> float:
        values = encoding.decode(np.clip(string, 0, 1))
        return evaluate(given.repaired(values[np.newaxis])[0])

    start = encoding.encode(given.start)
    options = {"popsize": 2, "maxiter": budget, "tol": 0, "polish": False, "rng": seed}
    differential_evolution(cost, [(0, 1)] * len(start), x0=start, **options)
