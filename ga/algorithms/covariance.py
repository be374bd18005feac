"""CMA-ES of the package ``cma`` behind the common interface."""

from typing import Any

import numpy as np

from stickslip.ga.algorithms.optimiser import Optimiser
from stickslip.ga.algorithms.settings import Limits
from stickslip.ga.errors import SettingsError
from stickslip.ga.problem.problem import Array, Encoding, Problem

SIGMA = 0.1  # first standard deviation of the search, on the strings' scale of [0, 1]
GROWTH = 2
"""Each restart, from a place at random, has so many times the population of the one before."""


class CovarianceAdaptation(Optimiser):
    """CMA-ES with restarts of growing population (IPOP).

    Source: Hansen, The CMA Evolution Strategy: A Tutorial, arXiv:1604.00772; Auger and Hansen, IEEE
    CEC (2005) 1769, for the restarts.
    """

    kind = "cma"
    title = "CMA-ES"

    def __init__(self, problem: Problem, limits: Limits, seed: int) -> None:
        super().__init__(problem, limits, seed)
        if len(problem.genes) < 2:
            raise SettingsError("the algorithm 'cma' needs two genes or more; use 'default'")
        self._encoding = Encoding.of(problem)
        self._rng = np.random.Generator(np.random.PCG64(seed))
        self._points: list[Array] = []
        self._strategy = self._begin(self._encoding.encode(problem.start), None)

    def _begin(self, string: Array, population: int | None) -> Any:
        import cma

        options = {
            "bounds": [0, 1],
            "seed": np.nan,  # leaves numpy's global generator alone
            "randn": lambda *shape: self._rng.standard_normal(shape),
            "verbose": -9,
            "verb_log": 0,
        }
        if population is not None:
            options["popsize"] = population
        return cma.CMAEvolutionStrategy(string, SIGMA, options)

    @property
    def batch(self) -> int:
        """How many candidates the next `ask` returns."""
        return int(self._strategy.popsize)

    def _propose(self) -> Array:
        self._points = self._strategy.ask()
        strings = np.array(self._points)
        if not self.generation:
            strings[0] = self._points[0] = self._encoding.encode(self.problem.start)
        return self.problem.repaired(self._encoding.decode(strings))

    def _digest(self, values: Array, costs: Array) -> Array:
        del values
        finite = costs[np.isfinite(costs)]
        worst = 10 * float(finite.max()) + 1 if finite.size else 1.0
        self._strategy.tell(self._points, np.where(np.isfinite(costs), costs, worst).tolist())
        if self._strategy.stop():
            anywhere = self._rng.random(len(self.problem.genes))
            self._strategy = self._begin(anywhere, GROWTH * self.batch)
        return costs
