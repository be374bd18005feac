"""Strings and values: what the operators see of a candidate, and what it means.

A candidate's string holds a number in [0, 1] for each gene. ``linear`` spreads the gene's bounds
evenly over it, as the paper does; ``log`` spreads their logarithms, so that every decade of a wide
range is searched alike. A gene that asks for it is linear in any encoding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stickslip.ga.arrays import Array
from stickslip.ga.errors import SettingsError
from stickslip.ga.problem.problem import Gene, Problem


class Encoding:
    """Translates between strings in [0, 1] and values in each gene's unit.

    Parameters
    ----------
    genes : k genes
    kind : ``linear`` or ``log``
    resolution : step of the strings; None leaves them continuous

    Raises
    ------
    SettingsError : a gene with ``log`` encoding has a lower bound that is not positive
    """

    def __init__(self, genes: Sequence[Gene], kind: str, resolution: float | None) -> None:
        self.lower = np.array([gene.lower for gene in genes])
        self.upper = np.array([gene.upper for gene in genes])
        self._log = np.array([kind == "log" and not gene.linear for gene in genes])
        self._resolution = resolution
        for gene, log in zip(genes, self._log, strict=True):
            if log and gene.lower <= 0:
                raise SettingsError(
                    f"gene {gene.name}: log encoding needs a lower bound above 0, "
                    f"got {gene.lower}; use linear=True, encoding='linear' or raise the bound"
                )
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
