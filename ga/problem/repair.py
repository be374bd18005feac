"""Constraints between genes, kept by repairing candidates before they are evaluated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.ga.arrays import Array
from stickslip.ga.errors import SettingsError
from stickslip.ga.problem.gene import Gene

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
