"""What is searched: the genes and what must hold between them. Every optimiser takes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.ga.arrays import Array
from stickslip.ga.errors import SettingsError
from stickslip.ga.problem.gene import Gene
from stickslip.ga.problem.repair import Repair


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
