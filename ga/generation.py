"""A generation: candidates whose costs are known, the best first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ga.arrays import Array
from ga.settings import Settings


@dataclass(frozen=True)
class Candidate:
    """A parameter vector and what it costs.

    Parameters
    ----------
    values : shape (k,), in the genes' order and units
    cost : 0 .. inf
    """

    values: Array
    cost: float


@dataclass(frozen=True)
class Generation:
    """Candidates in order of cost.

    Parameters
    ----------
    strings : what the operators work on, shape (n, k), 0 .. 1
    values : what was evaluated, shape (n, k), in the genes' units
    costs : shape (n,), 0 .. inf
    """

    strings: Array
    values: Array
    costs: Array

    def best(self) -> Candidate:
        """Return the first of the ranked candidates."""
        values = self.values
        return Candidate(values[0].copy(), float(self.costs[0]))

    def ranked(self) -> Generation:
        """Sort best first; equals keep their order."""
        order = np.argsort(self.costs, kind="stable")
        return Generation(self.strings[order], self.values[order], self.costs[order])

    def followed_by(self, children: Generation, settings: Settings) -> Generation:
        """Return the next generation: the elite, then in each place the child or its rival.

        Source
        ------
        Paper, Step 4, part 4 (survival ``generational``).
        """
        wins = np.ones(len(self.costs), dtype=bool)
        wins[: settings.elites] = False
        if settings.survival == "rival":
            wins[settings.elites :] = children.costs <= self.costs[settings.elites :]
        chosen = wins[settings.elites :]
        strings, values, costs = self.strings.copy(), self.values.copy(), self.costs.copy()
        strings[wins] = children.strings[chosen]
        values[wins] = children.values[chosen]
        costs[wins] = children.costs[chosen]
        return Generation(strings, values, costs).ranked()
