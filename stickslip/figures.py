"""Figures of a run: what functions of the user make of its result.

Each worker process of a sweep imports this module, which imports little.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from stickslip import cosim, ga
from stickslip.errors import UsageError, number

Figure = Callable[[cosim.Result], float]  # evaluates a run to a number


@dataclass(frozen=True)
class Figures:
    """All figures of a run."""

    by_name: Mapping[str, Figure]

    def __call__(self, result: cosim.Result) -> dict[str, Any]:
        """Return the figures, and the reason where one failed."""
        found: dict[str, Any] = {}
        for name, of in self.by_name.items():
            try:
                found[name] = figure(f"figure {name!r}", of, result)
            except ga.CandidateFailed as fault:
                found.setdefault("reason", str(fault))
        return found


def figure(what: str, of: Figure, result: cosim.Result) -> float:
    """Return what a function of the user makes of a run; raise CandidateFailed where it fails."""
    try:
        value = of(result)
    except Exception as fault:
        raise ga.CandidateFailed(f"{what}: {type(fault).__name__}: {fault}") from fault
    try:
        return number(what, value)
    except UsageError as fault:
        raise ga.CandidateFailed(str(fault)) from None
