"""The face that all optimisers share: ask for candidates, tell their costs.

    ask -> tell -> ask -> tell -> ...

An optimiser evaluates nothing itself and all its randomness is its own, so the result does not
depend on where or in which order the candidates are evaluated. Its state is what it was told: told
the same again, it is the same again.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from stickslip.ga.algorithms.settings import PROGRESS, Limits
from stickslip.ga.errors import CallOrderError, CostError, StateError
from stickslip.ga.execution import checkpoint
from stickslip.ga.execution.checkpoint import Record
from stickslip.ga.problem.problem import Array, Problem

if TYPE_CHECKING:
    import pandas as pd

NOT_A_NUMBER = "the cost is not a number"


@dataclass(frozen=True)
class Candidate:
    """A parameter vector (k,), in the genes' order and units, and what it costs, 0 .. inf."""

    values: Array
    cost: float


class Optimiser(ABC):
    """Searches a problem by ask and tell.

    Parameters
    ----------
    problem : the genes and their constraint
    limits : when to stop
    seed : of all randomness; the same seed and costs give the same history, bit for bit
    """

    kind: ClassVar[str]
    """what a checkpoint calls it"""
    title: ClassVar[str]
    """what people call it"""

    def __init__(self, problem: Problem, limits: Limits, seed: int) -> None:
        self.problem = problem
        self.limits = limits
        self.seed = seed
        self._record = Record()
        self._asked: Array | None = None
        self._best: Candidate | None = None
        self._progress = (0, np.inf)

    @property
    @abstractmethod
    def batch(self) -> int:
        """How many candidates the next `ask` returns."""

    @abstractmethod
    def _propose(self) -> Array:
        """Return the next candidates, shape (batch, k), in bounds and repaired."""

    @abstractmethod
    def _digest(self, values: Array, costs: Array) -> Array:
        """Take the proposal (n, k) and its costs (n,); return those of the generation it leaves."""

    def _options(self) -> dict[str, Any]:
        """Return as plain data what a checkpoint must agree with, besides the problem."""
        return {}

    def _converged(self) -> str | None:
        """Return why the method itself sees no point in going on, or None."""
        return None

    def _foreseen(self) -> Array:
        """Return the rows of the next proposal that are certain already, shape (m, k)."""
        return np.empty((0, len(self.names)))

    def ask(self) -> Array:
        """Return the candidates (n, k) to evaluate next, in the genes' units, first the start.

        It is a CallOrderError when those asked for before have not been told.
        """
        if self._asked is not None:
            advice = f"first tell the costs of the {len(self._asked)} candidates already asked"
            raise CallOrderError(f"ask was called twice; {advice}")
        self._asked = self._propose()
        return self._asked.copy()

    def tell(self, costs: ArrayLike, reasons: Sequence[str] | None = None) -> None:
        """Take the costs of the candidates that `ask` returned, in their order.

        Parameters
        ----------
        costs : shape (n,), 0 .. inf; inf for a candidate that failed. NaN counts as inf
        reasons : why each failed, n texts, empty where it did not

        Raises
        ------
        CallOrderError : nothing was asked
        CostError : wrong number of costs or reasons, or a negative cost; they can still be told
        """
        if self._asked is None:
            raise CallOrderError("tell was called before ask; ask for candidates first")
        values = self._asked
        told = np.array(costs, dtype=float)
        notes = [""] * len(values) if reasons is None else list(reasons)
        if told.shape != (len(values),) or len(notes) != len(values):
            wanted = f"{len(values)} costs (and as many reasons), one per candidate asked"
            got = f"costs of shape {told.shape} and {len(notes)} reasons"
            raise CostError(f"tell expects {wanted}, got {got}")
        for index in np.flatnonzero(np.isnan(told)):
            told[index], notes[index] = np.inf, notes[index] or NOT_A_NUMBER
        if (told < 0).any():
            what = f"because fitness is their inverse, got {told.min()}"
            raise CostError(f"costs must be 0 or above, {what}")
        self._record.add(values, told, notes)
        lowest = int(np.argmin(told))
        if self._best is None or told[lowest] < self._best.cost:
            self._best = Candidate(values[lowest].copy(), float(told[lowest]))
        generation = self._digest(values, told)
        self._record.close_generation(generation, self._best.cost)
        if self._best.cost <= self._progress[1] * (1 - PROGRESS):
            self._progress = self.evaluations, self._best.cost
        self._asked = None

    @property
    def ahead(self) -> Array:
        """What the next `ask` will return, as far as that is known before this one's costs.

        Shape (m, k), in the genes' units. Idle workers may begin with it. There is none if the
        limits leave no next generation, and a method that restarts discards it.
        """
        asked = 0 if self._asked is None else len(self._asked)
        none_left = self.limits.spent(
            generations=self.generation + 1, evaluations=self.evaluations + asked, batch=self.batch
        )
        return np.empty((0, len(self.names))) if none_left or not asked else self._foreseen()

    @property
    def names(self) -> list[str]:
        """The genes' names."""
        return self.problem.names

    @property
    def best(self) -> Candidate:
        """The candidate of the lowest cost so far; CallOrderError before costs were told."""
        if self._best is None:
            raise CallOrderError("there is no best candidate yet; ask and tell first")
        best = self._best
        return Candidate(best.values.copy(), best.cost)  # noqa: PD011 - an array

    @property
    def generation(self) -> int:
        """How many generations have been told."""
        return len(self._record.summaries)

    @property
    def evaluations(self) -> int:
        """How many candidates have been told."""
        return len(self._record.evaluations)

    @property
    def stopped(self) -> str | None:
        """Why learning should stop (paper, Step 3), or None. `ask` goes on regardless."""
        if self._best is None:
            return None
        return (
            self.limits.reached(
                generations=self.generation,
                evaluations=self.evaluations,
                batch=self.batch,
                best=self._best.cost,
                stagnant=self.evaluations - self._progress[0],
            )
            or self._converged()
        )

    @property
    def history(self) -> pd.DataFrame:
        """Every evaluation: generation, index, a column per gene, cost, reason."""
        return self._record.history(self.names)

    def convergence(self) -> pd.DataFrame:
        """Every generation: generation, evaluations, best_cost, mean_cost (see `Summary`)."""
        return self._record.convergence()

    def state(self) -> dict[str, Any]:
        """Everything needed to go on later, as plain data that JSON keeps exactly.

        Between `ask` and `tell` it is the state before `ask`, which will ask the same again.
        """
        return checkpoint.pack(self._head(), self._record)

    def replay(self, state: Mapping[str, Any]) -> None:
        """Go on from what `state` returned: bit for bit as if the run had not been interrupted.

        The optimiser must be new. It asks again what it asked then, and is told what it was told.

        Raises
        ------
        CallOrderError : the optimiser is not new
        StateError : the state is of other genes or settings, or is no state
        """
        if self._asked is not None or self._best is not None:
            raise CallOrderError("replay needs a new optimiser; this one has been asked before")
        for values, costs, reasons in checkpoint.unpack(self._head(), state):
            if not np.array_equal(self.ask(), values):
                what = f"generation {self.generation + 1} of the checkpoint cannot be repeated"
                why = "made with other versions of the packages or on another kind of processor"
                raise StateError(f"{what}; it was {why}; resume there or start afresh")
            self.tell(costs, reasons)

    def _head(self) -> dict[str, Any]:
        return checkpoint.head(self.kind, self.problem, self._options(), self.seed)
