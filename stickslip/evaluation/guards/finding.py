"""The finding of a guard."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One warning.

    Attributes
    ----------
    guard : name of the guard
    figure, limit : what was found and the largest acceptable value, in ``unit``
    message : what, figure, limit and what to do, in a line
    """

    guard: str
    figure: float
    limit: float
    unit: str
    message: str

    def __str__(self) -> str:
        return f"{self.guard}: {self.message}"
