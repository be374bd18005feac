"""The genetic algorithm: ask for candidates, tell their costs, generation after generation.

    ask -> tell -> ask -> tell -> ...

It evaluates nothing itself and all its randomness is here, so the result does not depend on where
or in which order the candidates are evaluated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ga import checkpoint
from ga.arrays import Array
from ga.breeding import breed
from ga.encoding import Encoding
from ga.errors import CallOrderError, CostError, SettingsError
from ga.gene import Gene
from ga.generation import Candidate, Generation
from ga.initial import first_generation
from ga.record import Record
from ga.repair import Repair
from ga.settings import DEFAULT, Settings

NOT_A_NUMBER = "the cost is not a number"


class GeneticAlgorithm:
    """Ask/tell genetic algorithm on k genes.

    Parameters
    ----------
    genes : what to learn, k of them
    settings : how; see `Settings` and `PRESETS`
    seed : of all randomness; the same seed and costs give the same history, bit for bit
    repair : makes candidates keep a constraint, e.g. `AtLeast`; its result is held to the bounds

    Raises
    ------
    SettingsError : no genes, two of one name, or bounds that the encoding cannot take
    """

    def __init__(
        self,
        genes: Sequence[Gene],
        settings: Settings = DEFAULT,
        seed: int = 0,
        repair: Repair | None = None,
    ) -> None:
        self.genes = tuple(genes)
        self.settings = settings
        self.names = [gene.name for gene in self.genes]
        if not self.genes or len(set(self.names)) < len(self.names):
            raise SettingsError(
                f"genes must be one or more, each with its own name, got {self.names}"
            )
        self._repair = repair
        self._encoding = Encoding(self.genes, settings.encoding, settings.resolution)
        self._rng = np.random.Generator(np.random.PCG64(seed))
        self._rng_at_tell = self._rng.bit_generator.state
        self._current: Generation | None = None
        self._asked: tuple[Array, Array] | None = None
        self._record = Record()

    def ask(self) -> Array:
        """Return the candidates to evaluate next.

        The first generation holds the start as its first row. Later ones hold only children: the
        elite's costs are known, and the cost is taken to be deterministic.

        Returns
        -------
        ndarray, shape (n, k), in the genes' units: n is the population at first, then the
        population without the elite

        Raises
        ------
        CallOrderError : the candidates asked for before have not been told
        """
        if self._asked is not None:
            raise CallOrderError(
                f"ask was called twice; first tell the costs of the {len(self._asked[1])} "
                "candidates already asked"
            )
        if self._current is None:
            start = np.array([[gene.start for gene in self.genes]])
            strings = first_generation(self._encoding.encode(start)[0], self.settings, self._rng)
        else:
            strings = breed(self._current.strings, self._current.costs, self.settings, self._rng)
        strings = self._encoding.settle(strings)
        values = self._encoding.decode(strings)
        if self._repair is not None:
            repaired = self._repair(values.copy(), self.genes)
            if repaired.shape != values.shape:
                raise SettingsError(
                    f"repair must return the population's shape {values.shape}, "
                    f"got {repaired.shape}"
                )
            values = np.clip(repaired, self._encoding.lower, self._encoding.upper)
            strings = self._encoding.encode(values)
        self._asked = strings, values
        return values.copy()

    def tell(self, costs: ArrayLike, reasons: Sequence[str] | None = None) -> None:
        """Take the costs of the candidates that `ask` returned, in their order.

        Parameters
        ----------
        costs : shape (n,), 0 .. inf; inf for a candidate that failed. NaN counts as inf, with
            the reason "the cost is not a number".
        reasons : why each failed, n texts, empty where it did not

        Raises
        ------
        CallOrderError : nothing was asked
        CostError : wrong number of costs or reasons, or a negative cost. The candidates can
            still be told.
        """
        if self._asked is None:
            raise CallOrderError("tell was called before ask; ask for candidates first")
        strings, values = self._asked
        told = np.array(costs, dtype=float)
        notes = [""] * len(values) if reasons is None else list(reasons)
        if told.shape != (len(values),) or len(notes) != len(values):
            raise CostError(
                f"tell expects {len(values)} costs (and as many reasons), one per candidate asked, "
                f"got costs of shape {told.shape} and {len(notes)} reasons"
            )
        for index in np.flatnonzero(np.isnan(told)):
            told[index], notes[index] = np.inf, notes[index] or NOT_A_NUMBER
        if (told < 0).any():
            raise CostError(
                f"costs must be 0 or above, because fitness is their inverse, got {told.min()}"
            )
        children = Generation(strings, values, told)
        self._record.add(values, told, notes)
        if self._current is None:
            self._current = children.ranked()
        else:
            self._current = self._current.followed_by(children, self.settings)
        self._record.close_generation(self._current.costs)
        self._asked = None
        self._rng_at_tell = self._rng.bit_generator.state

    @property
    def best(self) -> Candidate:
        """The candidate of the lowest cost so far.

        Raises
        ------
        CallOrderError : no costs have been told
        """
        if self._current is None:
            raise CallOrderError("there is no best candidate yet; ask and tell first")
        return self._current.best()

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
        """Why learning should stop, or None. `ask` goes on regardless.

        Source
        ------
        Paper, Step 3.
        """
        threshold = self.settings.threshold
        if self._current is not None and threshold is not None and self.best.cost <= threshold:
            return f"the best cost {self.best.cost:.6g} reached the threshold {threshold:.6g}"
        if self.generation >= self.settings.generations:
            return f"all {self.settings.generations} generations are done"
        return None

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
        return checkpoint.pack(
            self.genes, self.settings, self._rng_at_tell, self._current, self._record
        )

    @classmethod
    def from_state(
        cls,
        genes: Sequence[Gene],
        settings: Settings,
        state: Mapping[str, Any],
        repair: Repair | None = None,
    ) -> GeneticAlgorithm:
        """Go on from `state`: bit for bit as if it had never been interrupted.

        Parameters
        ----------
        genes, settings, repair : as at first; `generations` and `threshold` may have changed
        state : what `state` returned, also after a round trip through JSON

        Raises
        ------
        StateError : the state is of other genes or settings, or is no state
        """
        algorithm = cls(genes, settings, repair=repair)
        algorithm._current, algorithm._record, rng_state = checkpoint.unpack(
            algorithm.genes, settings, state
        )
        algorithm._rng.bit_generator.state = rng_state
        algorithm._rng_at_tell = rng_state
        return algorithm
