"""NEW_TITLE: candidates that are independent of each other."""

import numpy as np

from stickslip.ga.algorithms.optimiser import Optimiser
from stickslip.ga.algorithms.settings import Limits
from stickslip.ga.problem.problem import Array, Encoding, Problem


class Search(Optimiser):
    """Draws each candidate uniformly from the ranges of the genes."""

    kind = "NEW_NAME"  # the name for --algorithm and in checkpoints
    title = "NEW_TITLE"
    batch = 10

    def __init__(self, problem: Problem, limits: Limits, seed: int) -> None:
        super().__init__(problem, limits, seed)
        self._rng = np.random.default_rng(seed)
        self._encoding = Encoding.of(problem)

    def _propose(self) -> Array:
        strings = self._rng.random((self.batch, len(self.problem.genes)))
        if not self.evaluations:
            start = np.array([gene.start for gene in self.problem.genes])
            strings[0] = self._encoding.encode(start)
        return self.problem.repaired(self._encoding.decode(strings))

    def _digest(self, values: Array, costs: Array) -> Array:  # noqa: ARG002 - learns nothing
        return costs
