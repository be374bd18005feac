"""What is searched: genes, what must hold between them, and the strings that operators see."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.ga.errors import SettingsError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Gene:
    """One parameter that the algorithm may change.

    Parameters
    ----------
    name : what the parameter is called where it is used, e.g. ``compensator.F_c``
    lower, upper : bounds of the search, in `unit`
    start : the coarsely identified value, in `unit`
    unit : as displayed
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
            what = f"lower must be below upper, got {self.lower} and {self.upper}"
            raise SettingsError(f"gene {self.name}: {what}")
        if not self.lower <= self.start <= self.upper:
            what = f"its bounds {self.lower} .. {self.upper}; widen them or move the start"
            raise SettingsError(f"gene {self.name}: start {self.start} is outside {what}")


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
            what = f"below the lower bound {genes[low].lower} of {self.smaller}; widen the bounds"
            raise SettingsError(f"AtLeast: {self.larger} ends at {genes[high].upper}, {what}")
        pair = values[:, [low, high]]
        repaired = values.copy()
        for column, chosen in ((high, pair.max(axis=1)), (low, pair.min(axis=1))):
            repaired[:, column] = np.clip(chosen, genes[column].lower, genes[column].upper)
        return repaired


@dataclass(frozen=True)
class Problem:
    """k genes and a constraint between them.

    ``repair`` makes candidates keep it, e.g. `AtLeast`; its result is held to the bounds. It is a
    SettingsError to have no genes, or two of one name.
    """

    genes: Sequence[Gene]
    repair: Repair | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "genes", tuple(self.genes))
        if not self.genes or len(set(self.names)) < len(self.names):
            what = "genes must be one or more, each with its own name"
            raise SettingsError(f"{what}, got {self.names}")

    @property
    def names(self) -> list[str]:
        """The genes' names."""
        return [gene.name for gene in self.genes]

    @property
    def start(self) -> Array:
        """Where the search begins, shape (k,), in the genes' units."""
        return np.array([gene.start for gene in self.genes])

    def repaired(self, values: Array) -> Array:
        """Return candidates (n, k) in constraint and bounds; SettingsError for another shape."""
        if self.repair is None:
            return values
        repaired = self.repair(values.copy(), self.genes)
        if repaired.shape != values.shape:
            got = f"{values.shape}, got {repaired.shape}"
            raise SettingsError(f"repair must return the population's shape {got}")
        lower, upper = np.array([(gene.lower, gene.upper) for gene in self.genes]).T
        return np.clip(repaired, lower, upper)


class Encoding:
    """Translates between strings in [0, 1], with a resolution or None, and values of k genes."""

    def __init__(self, genes: Sequence[Gene], kind: str, resolution: float | None) -> None:
        self.lower = np.array([gene.lower for gene in genes])
        self.upper = np.array([gene.upper for gene in genes])
        self._log = np.array([kind == "log" and not gene.linear for gene in genes])
        self._resolution = resolution
        for gene, log in zip(genes, self._log, strict=True):
            if log and gene.lower <= 0:
                what = f"log encoding needs a lower bound above 0, got {gene.lower}"
                advice = "use linear=True, encoding='linear' or raise the bound"
                raise SettingsError(f"gene {gene.name}: {what}; {advice}")
        self._origin = self._scale(self.lower)
        self._span = self._scale(self.upper) - self._origin

    @classmethod
    def of(cls, problem: Problem) -> Encoding:
        """Return the encoding for a problem that has none of its own: log wherever it can be."""
        kinds = [gene if gene.lower > 0 else replace(gene, linear=True) for gene in problem.genes]
        return cls(kinds, "log", None)

    def encode(self, values: Array) -> Array:
        """Return the strings, shape (n, k), of values inside the bounds, shape (n, k)."""
        return np.clip((self._scale(values) - self._origin) / self._span, 0.0, 1.0)

    def decode(self, strings: Array) -> Array:
        """Return the values, shape (n, k), of strings, shape (n, k); never outside the bounds."""
        scaled = self._origin + strings * self._span
        scaled[..., self._log] = np.exp(scaled[..., self._log])
        return np.clip(scaled, self.lower, self.upper)

    def settle(self, strings: Array) -> Array:
        """Mirror strings that left [0, 1] back at its ends, then round to the resolution."""
        mirrored = np.abs(strings)
        inside = np.clip(np.where(mirrored > 1, 2 - mirrored, mirrored), 0.0, 1.0)
        if self._resolution is None:
            return inside
        return np.clip(np.rint(inside / self._resolution) * self._resolution, 0.0, 1.0)

    def _scale(self, values: Array) -> Array:
        scaled = np.array(values)
        scaled[..., self._log] = np.log(scaled[..., self._log])
        return scaled
