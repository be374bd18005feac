"""A generation: candidates whose costs are known, the best first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.ga.algorithms.settings import Settings
from stickslip.ga.arrays import Array

Mask = NDArray[np.bool_]


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
    runs : how many evaluations each cost is the mean of, shape (n,)
    """

    strings: Array
    values: Array
    costs: Array
    runs: Array

    @classmethod
    def once(cls, strings: Array, values: Array, costs: Array) -> Generation:
        """Return candidates that were evaluated once."""
        return cls(strings, values, costs, np.ones(len(costs)))

    def candidate(self, row: int) -> Candidate:
        """Return one of the candidates."""
        return Candidate(self.values[row].copy(), float(self.costs[row]))

    def ranked(self) -> Generation:
        """Sort best first; equals keep their order."""
        order = np.argsort(self.costs, kind="stable")
        return Generation(
            self.strings[order], self.values[order], self.costs[order], self.runs[order]
        )

    def averaged(self, costs: Array) -> Generation:
        """Return the generation with the first ones evaluated once more, at these costs."""
        means, runs = self.costs.copy(), self.runs.copy()
        again = slice(len(costs))
        runs[again] += 1
        means[again] += (costs - means[again]) / runs[again]
        return Generation(self.strings, self.values, means, runs)

    def winners(self, children: Generation, settings: Settings) -> Mask:
        """Return which children, shape (m,), take the places behind the elite.

        Source
        ------
        Paper, Step 4, part 4 (survival ``generational``).
        """
        if settings.survival == "rival":
            return children.costs <= self.costs[settings.elites :]
        return np.ones(len(children.costs), dtype=bool)

    def followed_by(self, children: Generation, wins: Mask) -> Generation:
        """Return the next generation: the elite, then in each place the child or its rival."""
        places = len(self.costs) - len(wins) + np.flatnonzero(wins)
        parts = []
        for mine, theirs in (
            (self.strings, children.strings),
            (self.values, children.values),
            (self.costs, children.costs),
            (self.runs, children.runs),
        ):
            new = mine.copy()
            new[places] = theirs[wins]
            parts.append(new)
        return Generation(*parts).ranked()
