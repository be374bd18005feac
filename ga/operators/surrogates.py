"""Children where models of the cost are lowest, besides those of crossover and mutation.

A quadratic finds the minimum of one valley in a few steps. A round bowl has so few coefficients
that it averages out small valleys and finds the large one. Sections search gene by gene.
"""

from __future__ import annotations

from threading import Lock

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from stickslip.ga.arrays import Array
from stickslip.ga.operators.quadratic import bottom, bowl
from stickslip.ga.operators.rates import Shares
from stickslip.ga.operators.sections import Sections

ARCHIVED = 4096
"""Candidates kept."""


class Archive:
    """Keeps the cheapest candidates on k genes.

    Attributes
    ----------
    strings : the cheapest first, shape (n, k)
    costs : shape (n,), 0 .. inf
    """

    def __init__(self, genes: int) -> None:
        self.strings = np.empty((0, genes))
        self.costs = np.empty(0)

    def add(self, strings: Array, costs: Array) -> None:
        """Take candidates, shape (n, k), and their costs, shape (n,)."""
        all_costs = np.concatenate([self.costs, costs])
        order = np.argsort(all_costs, kind="stable")[:ARCHIVED]
        self.strings = np.vstack([self.strings, strings])[order]
        self.costs = all_costs[order]


BRED, SECTION, BOWL, QUADRATIC = range(4)
"""Where a child comes from."""

_LIBRARIES, _LIMITED = ThreadpoolController(), Lock()

FIRST = 20.0, 0.4, 0.4
"""What is expected of the first three, relative to each other, before anything is known."""

Origins = NDArray[np.int_]


class Surrogates:
    """Replaces some of a generation's children; those of what succeeds more often.

    The last child, whose rival is the worst of the generation, is always the quadratic's.

    Parameters
    ----------
    genes : k
    """

    def __init__(self, genes: int) -> None:
        self._genes = genes
        self._all = Archive(genes)
        self._shares = Shares(FIRST)
        self.restart()

    def restart(self) -> None:
        """Forget where the search is, but not what was seen."""
        self._near = Archive(self._genes)
        self._sections: Sections | None = None

    def centre(self) -> Array | None:
        """Return where the cost is lowest by and large, shape (k,) if the model has one."""
        return bowl(self._all.strings, self._all.costs)

    def add(self, strings: Array, costs: Array) -> None:
        """Take candidates, shape (n, k), and their costs, shape (n,), 0 .. inf."""
        self._all.add(strings, costs)
        self._near.add(strings, costs)

    def follow(self, origins: Origins, strings: Array, costs: Array, best: float) -> None:
        """Learn what children (n, k) of these origins cost, where the best one cost that much."""
        self._shares.follow(origins[:-1], costs[:-1] < best)
        for index in np.flatnonzero(origins == SECTION):
            if self._sections is not None:
                self._sections.add(strings[index], float(costs[index]))

    def move(self, string: Array, cost: float) -> None:
        """Take the best candidate, shape (k,), of the generation."""
        if self._sections is not None:
            self._sections.move(string, cost)
        elif np.isfinite(cost):
            self._sections = Sections(string, cost)

    def place(self, children: Array, rng: np.random.Generator, *, spread: bool) -> Origins:
        """Replace some of the children (n, k) in place; return where each comes from, (n,).

        Where the population is not spread any more, it breeds nothing new, and sections do.
        """
        # The threads of linear algebra cost more than they bring. Their number belongs to the
        # process: two searches that change it at once would not put it back.
        with _LIMITED, _LIBRARIES.limit(limits=1, user_api="blas"):
            return self._place(children, rng, spread)

    def _place(self, children: Array, rng: np.random.Generator, spread: bool) -> Origins:
        origins = self._shares.draw(len(children), rng)
        if not spread:
            origins[:] = SECTION
        origins[-1] = QUADRATIC
        few, most = 2 * (self._genes + 2), len(self._near.costs)
        lowest: list[Array | None] = [None] * len(children)
        for index in np.flatnonzero(origins == BOWL).tolist():
            n = round(few * (max(most, few) / few) ** rng.random())
            lowest[index] = bowl(self._near.strings[:n], self._near.costs[:n])
        lowest[-1] = bottom(self._near.strings, self._near.costs)
        if self._sections is not None:
            mine = np.flatnonzero(origins == SECTION)
            for index, child in zip(
                mine.tolist(), self._sections.propose(len(mine), rng), strict=True
            ):
                lowest[index] = child
        for index, child in enumerate(lowest):
            if child is not None:
                children[index] = child
        return np.where([child is None for child in lowest], BRED, origins)
