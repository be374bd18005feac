"""Who races: ours, and the same problem given to scipy, cma and pymoo as their manuals say.

All search the logarithms of the genes from the same start, keep F_s >= F_c by the same repair and
have the same budget, except for the paper's preset, which is as published.
"""

import contextlib
import time
import warnings
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
from scipy.optimize import differential_evolution

from stickslip import ga
from stickslip.ga.problem.problem import Encoding

Cost = Callable[[np.ndarray], float]
Racer = Callable[[Cost, ga.Problem, int, int], None]
"""(cost of values (k,), problem, seed, budget): evaluates until `Spent` is raised or it is done"""
FAILED = 1e9  # the others do not all take infinity
SIGMAS = (0.1, 0.2)


class Spent(Exception):
    """The budget is used up."""


class Clock:
    """Counts a racer's evaluations and takes the time of each that is better than all before."""

    def __init__(self, evaluate: Cost, budget: int) -> None:
        self._cost, self._budget = evaluate, budget
        self.evaluations, self.best = 0, np.inf
        self.rows: list[tuple[int, float, float]] = []
        self.found: np.ndarray | None = None
        self._begin = time.process_time()

    def __call__(self, values: np.ndarray) -> float:
        if self.evaluations == self._budget:
            raise Spent
        self.evaluations += 1
        found = self._cost(values)
        if found < self.best:
            self.best, self.found = found, values.copy()
            self.rows.append((self.evaluations, time.process_time() - self._begin, found))
        return found


def race_one(racer: Racer, evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> Clock:
    """Let one of them search a problem, and return what it found when."""
    clock = Clock(evaluate, budget)
    with warnings.catch_warnings(), contextlib.suppress(Spent):
        warnings.simplefilter("ignore")  # of the others
        racer(clock, given, seed, budget)
    return clock


def ours(algorithm: str) -> Racer:
    def race(evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> None:
        if algorithm == "paper":
            given = ga.Problem(given.genes)
        optimiser = ga.optimiser(algorithm, given, ga.Limits(evaluations=budget), seed)
        ga.learn(optimiser, evaluate)

    return race


def _strings(evaluate: Cost, given: ga.Problem) -> tuple[Cost, np.ndarray]:
    """Return the cost of strings (k,) in [0, 1], and the start as one."""
    encoding = Encoding.of(given)

    def cost(string: np.ndarray) -> float:
        values = encoding.decode(np.clip(string, 0, 1))
        try:
            return evaluate(given.repaired(values[np.newaxis])[0])
        except ga.CandidateFailed:
            return FAILED

    return cost, encoding.encode(given.start)


def scipy_de(popsize: int) -> Racer:
    def race(evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> None:
        cost, start = _strings(evaluate, given)
        options = {"popsize": popsize, "maxiter": budget, "tol": 0, "polish": False, "rng": seed}
        differential_evolution(cost, [(0, 1)] * len(start), x0=start, **options)

    return race


def cma(sigma: float) -> Racer:
    def race(evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> None:
        from cma import fmin2

        cost, start = _strings(evaluate, given)
        size = 4 + int(3 * np.log(len(start)))
        for attempt in range(budget):
            options = {"bounds": [0, 1], "seed": 1 + seed + 1000 * attempt, "verbose": -9}
            fmin2(cost, start, sigma, {**options, "verb_log": 0, "popsize": 2**attempt * size})
            start = np.random.default_rng([seed, attempt]).random(len(start))

    return race


def pymoo_ga(population: int) -> Racer:
    def race(evaluate: Cost, given: ga.Problem, seed: int, budget: int) -> None:
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import ElementwiseProblem
        from pymoo.optimize import minimize

        cost, start = _strings(evaluate, given)

        class Genes(ElementwiseProblem):
            def __init__(self) -> None:
                super().__init__(n_var=len(start), n_obj=1, xl=0.0, xu=1.0)

            def _evaluate(self, x, out) -> None:
                out["F"] = cost(x)

        first = np.random.default_rng(seed).random((population, len(start)))
        first[0] = start
        algorithm = GA(pop_size=population, sampling=first)
        minimize(Genes(), algorithm, ("n_eval", budget), seed=seed)

    return race


def racers() -> dict[str, Racer]:
    """Return who races, and print who cannot."""
    found: dict[str, Racer] = {
        "ours, default": ours("default"),
        "ours, paper's preset": ours("paper"),
        "scipy DE, 10": scipy_de(2),
        "scipy DE, 75 (its default)": scipy_de(15),
    }
    peers: dict[str, dict[str, Racer]] = {
        "cma": {f"cma, sigma {sigma}": cma(sigma) for sigma in SIGMAS},
        "pymoo": {"pymoo GA, 20": pymoo_ga(20)},
    }
    for package, theirs in peers.items():
        if find_spec(package):
            found |= theirs
        else:
            print(f"  {package} is not installed and does not race")
    return found
