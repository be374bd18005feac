"""What is searched: the genes and what must hold between them. Every optimiser takes it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.ga.arrays import Array
from stickslip.ga.errors import SettingsError


@dataclass(frozen=True)
class Gene:
    """One parameter that the algorithm may change.

    Parameters
    ----------
    name : what the parameter is called where it is used, e.g. ``compensator.F_c``
    lower, upper : bounds of the search, in `unit`
    start : the coarsely identified value, in `unit`
    unit : for people and reports
    linear : search its values evenly even where other genes are logarithmic, e.g. an offset that
        may be negative

    Raises
    ------
    SettingsError : a value is not finite, the bounds are out of order or exclude the start
    """

    name: str
    lower: float
    upper: float
    start: float
    unit: str = ""
    linear: bool = False

    def __post_init__(self) -> None:
        values = {"lower": self.lower, "upper": self.upper, "start": self.start}
        for field, value in values.items():
            if not math.isfinite(value):
                raise SettingsError(f"gene {self.name}: {field} must be finite, got {value}")
        if not self.lower < self.upper:
            raise SettingsError(
                f"gene {self.name}: lower must be below upper, got {self.lower} and {self.upper}"
            )
        if not self.lower <= self.start <= self.upper:
            raise SettingsError(
                f"gene {self.name}: start {self.start} is outside its bounds "
                f"{self.lower} .. {self.upper}; widen them or move the start"
            )


Repair = Callable[[Array, Sequence[Gene]], Array]
"""(values (n, k) in the genes' units; the k genes) -> repaired values (n, k); keep it picklable"""


@dataclass(frozen=True)
class AtLeast:
    """Keeps the gene `larger` at or above the gene `smaller`, e.g. F_s >= F_c.

    A candidate that breaks this has the two values exchanged, each then held to its bounds.
    Raising F_s to F_c instead would heap candidates on F_s = F_c, where v_s has no effect and the
    search comes to rest: it learned worst of the four repairs that were tried.

    Raises
    ------
    SettingsError : on use, if a name is no gene or the bounds leave no room for the constraint
    """

    larger: str
    smaller: str

    def __call__(self, values: Array, genes: Sequence[Gene]) -> Array:
        """Repair a population, shape (n, k), in the genes' units; returns a new array."""
        names = [gene.name for gene in genes]
        for name in (self.larger, self.smaller):
            if name not in names:
                raise SettingsError(f"AtLeast: no gene {name!r} among {', '.join(names)}")
        high, low = names.index(self.larger), names.index(self.smaller)
        if genes[high].upper < genes[low].lower:
            raise SettingsError(
                f"AtLeast: {self.larger} ends at {genes[high].upper}, below the lower bound "
                f"{genes[low].lower} of {self.smaller}; widen the bounds"
            )
        pair = values[:, [low, high]]
        repaired = values.copy()
        for column, chosen in ((high, pair.max(axis=1)), (low, pair.min(axis=1))):
            repaired[:, column] = np.clip(chosen, genes[column].lower, genes[column].upper)
        return repaired


@dataclass(frozen=True)
class Problem:
    """k genes and a constraint between them.

    Parameters
    ----------
    genes : what to learn
    repair : makes candidates keep a constraint, e.g. `AtLeast`; its result is held to the bounds

    Raises
    ------
    SettingsError : no genes, or two of one name
    """

    genes: Sequence[Gene]
    repair: Repair | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "genes", tuple(self.genes))
        if not self.genes or len(set(self.names)) < len(self.names):
            raise SettingsError(
                f"genes must be one or more, each with its own name, got {self.names}"
            )

    @property
    def names(self) -> list[str]:
        """The genes' names."""
        return [gene.name for gene in self.genes]

    @property
    def start(self) -> Array:
        """Where the search begins, shape (k,), in the genes' units."""
        return np.array([gene.start for gene in self.genes])

    def repaired(self, values: Array) -> Array:
        """Return candidates, shape (n, k), that keep the constraint and the bounds.

        Raises
        ------
        SettingsError : the repair changes the shape
        """
        if self.repair is None:
            return values
        repaired = self.repair(values.copy(), self.genes)
        if repaired.shape != values.shape:
            raise SettingsError(
                f"repair must return the population's shape {values.shape}, got {repaired.shape}"
            )
        lower, upper = np.array([(gene.lower, gene.upper) for gene in self.genes]).T
        return np.clip(repaired, lower, upper)
