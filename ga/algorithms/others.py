"""CMA-ES of the package ``cma`` and differential evolution of scipy, behind the common interface.

scipy runs from beginning to end and calls the cost itself. It does so in a thread of its own here,
which waits wherever it wants costs; only one of the two threads ever runs.
"""

import weakref
from collections.abc import Callable, Iterable
from inspect import signature
from queue import SimpleQueue
from threading import Thread
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


POPULATION = 10
"""Candidates in a generation, or the next multiple of the genes; scipy's own 15 a gene are slower
by far within a thousand evaluations."""


class DifferentialEvolution(Optimiser):
    """scipy's ``best1bin``; restarts where all of a population cost the same.

    Source: Storn and Price, J. Global Optimization 11 (1997) 341, as in ``scipy.optimize``.
    """

    kind = "de"
    title = "differential evolution of scipy"

    def __init__(self, problem: Problem, limits: Limits, seed: int) -> None:
        super().__init__(problem, limits, seed)
        self._encoding = Encoding.of(problem)
        k = len(problem.genes)
        share = max(-(-POPULATION // k), -(-5 // k))  # scipy wants five at least
        self._population = share * k
        self._conversation = _Conversation()
        arguments = (self._encoding.encode(problem.start), share, seed)
        Thread(target=self._conversation.hold, args=arguments, daemon=True).start()
        weakref.finalize(self, self._conversation.answers.put, None)  # or the thread would wait

    @property
    def batch(self) -> int:
        """How many candidates the next `ask` returns."""
        return self._population

    def _propose(self) -> Array:
        question = self._conversation.questions.get()
        if isinstance(question, Exception):
            raise question
        return self.problem.repaired(self._encoding.decode(question))

    def _digest(self, values: Array, costs: Array) -> Array:
        del values
        self._conversation.answers.put(costs)
        return costs


class _Over(Exception):
    """Nobody listens any more."""


class _Conversation:
    """scipy's questions and the answers: strings (n, k) and costs (n,)."""

    def __init__(self) -> None:
        self.questions: SimpleQueue[Array | Exception] = SimpleQueue()
        self.answers: SimpleQueue[Array | None] = SimpleQueue()

    def hold(self, start: Array, share: int, seed: int) -> None:
        """Evolve a population of ``share`` candidates a gene from a start (k,), again and again."""
        from scipy.optimize import Bounds, differential_evolution

        bounds = Bounds(np.zeros(len(start)), np.ones(len(start)))
        first: Array | None = start
        names = signature(differential_evolution).parameters
        argument = "rng" if "rng" in names else "seed"  # before scipy 1.15
        random: dict[str, Any] = {argument: np.random.Generator(np.random.PCG64(seed))}
        try:
            while True:
                differential_evolution(
                    np.sum,  # never called: `costs` comes first
                    bounds,
                    popsize=share,
                    maxiter=2**31,
                    tol=0.0,
                    polish=False,
                    updating="deferred",
                    workers=self.costs,
                    x0=first,
                    **random,
                )
                first = None
        except _Over:
            return
        except Exception as error:  # noqa: BLE001 - it belongs into the thread that asks
            self.questions.put(error)

    def costs(self, function: Callable[[Array], float], strings: Iterable[Array]) -> Array:
        """Be the map that scipy evaluates a generation by."""
        del function
        self.questions.put(np.array(list(strings)))
        answer = self.answers.get()
        if answer is None:
            raise _Over
        return answer
