"""The genetic algorithm, generation after generation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.ga.algorithms.optimiser import Optimiser
from stickslip.ga.algorithms.settings import DEFAULT, PROGRESS, Limits, Settings
from stickslip.ga.operators.breeding import CROSSOVERS, MUTATIONS, MutationRate
from stickslip.ga.operators.surrogates import BRED, Origins, Surrogates
from stickslip.ga.problem.problem import Array, Encoding, Gene, Problem, Repair

COLLAPSED = 1e-3
"""A population whose strings all lie within this of each other has found the bottom of a valley."""

SETTLED = 6
"""Generations without 1 % of progress that it then has to go on, and as many again to find another
valley along the genes, before it restarts."""


Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Generation:
    """Strings (n, k), 0 to 1, which the operators work on, and the costs (n,) of what they mean."""

    strings: Array
    costs: Array

    def ranked(self) -> Generation:
        """Sort best first; equals keep their order."""
        order = np.argsort(self.costs, kind="stable")
        return Generation(self.strings[order], self.costs[order])

    def winners(self, children: Generation, settings: Settings) -> Mask:
        """Return which children (m,) take the places behind the elite (Paper, Step 4, part 4)."""
        if settings.survival == "rival":
            return children.costs <= self.costs[settings.elites :]
        return np.ones(len(children.costs), dtype=bool)

    def followed_by(self, children: Generation, wins: Mask) -> Generation:
        """Return the next generation: the elite, then in each place the child or its rival."""
        places = len(self.costs) - len(wins) + np.flatnonzero(wins)
        strings, costs = self.strings.copy(), self.costs.copy()
        strings[places], costs[places] = children.strings[wins], children.costs[wins]
        return Generation(strings, costs).ranked()


@dataclass(frozen=True)
class Brood:
    """Children, in the order of the places that they compete for."""

    strings: Array  # what the operators work on, (n, k), 0 to 1
    values: Array  # what is evaluated, (n, k), in the genes' units
    rates: Array  # of their mutation, (n, 1)
    origins: Origins  # where each comes from, (n,)


class GeneticAlgorithm(Optimiser):
    """Ask/tell genetic algorithm on k genes.

    The first generation holds the start as its first row. Later ones hold only children: the
    elite's costs are known.

    Parameters
    ----------
    genes : what to learn, k of them
    settings : how; see `Settings` and `PRESETS`
    seed : of all randomness; the same seed and costs give the same history, bit for bit
    repair : makes candidates keep a constraint, e.g. `AtLeast`; its result is held to the bounds
    limits : when to stop; by default the settings' ``generations`` and ``threshold``

    Raises
    ------
    SettingsError : no genes, two of one name, or bounds that the encoding cannot take
    """

    kind = "genetic"
    title = "a genetic algorithm"

    def __init__(
        self,
        genes: Sequence[Gene],
        settings: Settings = DEFAULT,
        seed: int = 0,
        repair: Repair | None = None,
        limits: Limits | None = None,
    ) -> None:
        own = Limits(generations=settings.generations, target=settings.threshold)
        super().__init__(Problem(genes, repair), limits or own, seed)
        self.genes = self.problem.genes
        self.settings = settings
        self._encoding = Encoding(self.genes, settings.encoding, settings.resolution)
        self._rng = np.random.Generator(np.random.PCG64(seed))
        self._surrogates = Surrogates(len(self.genes)) if settings.surrogates else None
        self._restart(restarts=0)

    def _restart(self, restarts: int) -> None:
        self._restarts = restarts
        self._current: Generation | None = None
        self._brood: Brood | None = None
        self._bred: Brood | None = None
        self._mutation = MutationRate(self.settings)
        if self._surrogates is not None:
            self._surrogates.restart()
        self._stale = 0, np.inf  # generations without progress, and the cost they have to beat
        self._settled_for = 0  # generations of these in which the population was collapsed

    @property
    def batch(self) -> int:
        """How many candidates the next `ask` returns.

        The population at first and after a restart, then the population without the elite.
        """
        if self._current is None:
            return self.settings.population
        return self.settings.population - self.settings.elites

    def _propose(self) -> Array:
        current = self._current
        if current is None:
            self._brood = self._first()
            return self._brood.values
        self._brood = self._bred or self._next(current)
        self._bred = self._next(current) if self.settings.ahead else None
        return self._brood.values

    def _foreseen(self) -> Array:
        return super()._foreseen() if self._bred is None else self._bred.values

    def _settled(self, strings: Array, rates: Array, origins: Origins) -> Brood:
        """Return what strings (n, k), which may leave [0, 1], are evaluated as."""
        strings = self._encoding.settle(strings)
        values = self._encoding.decode(strings)
        if self.problem.repair is not None:
            values = self.problem.repaired(values)
            strings = self._encoding.encode(values)
        return Brood(strings, values, rates, origins)

    def _first(self) -> Brood:
        """Return a first generation: around the start (paper, Step 1), or after a restart.

        The first restart is around where the cost is lowest by and large, the second anywhere, and
        so on in turns.
        """
        settings, n = self.settings, self.settings.population
        start: Array | None = self._encoding.encode(self.problem.start)
        if self._restarts:
            start = None
            if self._surrogates is not None and self._restarts % 2:
                start = self._surrogates.centre()
        if start is None:
            strings = self._rng.random((n, len(self.genes)))
        else:
            near = round(settings.near_share * (n - 1))
            around = settings.near_spread * self._rng.standard_normal((near, start.size))
            anywhere = self._rng.random((n - 1 - near, start.size))
            strings = np.vstack([start, start + around, anywhere])
        return self._settled(strings, np.empty((n, 1)), np.full(n, BRED))

    def _next(self, current: Generation) -> Brood:
        settings, strings = self.settings, current.strings
        rates = self._mutation.draw(settings.population - settings.elites, self._rng)
        children = CROSSOVERS[settings.crossover](strings, current.costs, settings, self._rng)
        strings = MUTATIONS[settings.mutation](children, strings, rates, self._rng)
        origins = np.full(len(strings), BRED)
        if self._surrogates is not None:
            origins = self._surrogates.place(strings, self._rng, spread=self._settled_for < SETTLED)
        return self._settled(strings, rates, origins)

    def _digest(self, values: Array, costs: Array) -> Array:
        del values  # they are in the brood
        brood = self._brood
        assert brood is not None  # noqa: S101 - something was asked
        children, rivals = Generation(brood.strings, costs), self._current
        if rivals is None:
            current = children.ranked()
        else:
            wins = rivals.winners(children, self.settings)
            self._mutation.follow(brood.rates, wins)
            current = rivals.followed_by(children, wins)
        if self._surrogates is not None:
            self._surrogates.add(brood.strings, costs)
            if rivals is not None:
                lowest = float(rivals.costs[0])
                self._surrogates.follow(brood.origins, brood.strings, costs, lowest)
            self._surrogates.move(current.strings[0], float(current.costs[0]))
        self._current = current
        self._watch(current)
        return current.costs

    def _watch(self, current: Generation) -> None:
        """Count generations without progress, and restart when it is time."""
        stale, goal = self._stale
        lowest = float(current.costs[0])
        self._stale = (0, lowest * (1 - PROGRESS)) if lowest <= goal else (stale + 1, goal)
        collapsed = float(np.ptp(current.strings, axis=0).max()) <= COLLAPSED
        self._settled_for = self._settled_for + 1 if collapsed and self._stale[0] else 0
        if self._at_rest() and self._restarts < self.settings.restarts:
            self._restart(self._restarts + 1)

    def _at_rest(self) -> bool:
        patience = self.settings.patience
        stale = self._stale[0]
        return patience is not None and (stale >= patience or self._settled_for >= 2 * SETTLED)

    def _converged(self) -> str | None:
        if not self._at_rest():
            return None
        why = f"the best cost has not fallen by 1 % in {self._stale[0]} generations"
        if self._settled_for >= 2 * SETTLED:
            why = "the population has collapsed to a point"
        return f"stagnation: {why}, after {self._restarts} restarts"

    def _options(self) -> dict[str, Any]:
        kept = asdict(self.settings)
        del kept["generations"], kept["threshold"]  # a run may go on for longer than first planned
        return kept
