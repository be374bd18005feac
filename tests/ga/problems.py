"""Costs that pickle, and costs that misbehave where they are evaluated."""

import os
import signal
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip import ga

GENES = [
    ga.Gene("a", 0.1, 100.0, 1.0, "N"),
    ga.Gene("b", 0.6, 600.0, 6.0, "N"),
    ga.Gene("c", 1e-5, 1e-2, 1e-4, "m/s"),
]
TARGET = np.array([2.0, 4.0, 3e-4])


def quadratic(values: np.ndarray) -> float:
    """Squared distance to TARGET in decades."""
    return float(np.sum(np.log10(values / TARGET) ** 2))


def sometimes_fails(values: np.ndarray) -> float:
    if values[0] > 2:
        raise ga.CandidateFailed(f"a = {values[0]:.3g} is too much")
    return quadratic(values)


def always_fails(values: np.ndarray) -> float:
    raise ga.CandidateFailed(f"no luck with {values.size} genes")


def breaks(values: np.ndarray) -> float:
    raise ZeroDivisionError(f"{values.size} genes")


@dataclass(frozen=True)
class KillsItsWorker:
    """Costs as `quadratic`, but the process dies: above a limit of gene a, or once."""

    parent: int
    limit: float = np.inf
    once: Path | None = None

    def __call__(self, values: np.ndarray) -> float:
        if self.once is not None:
            with suppress(FileNotFoundError):  # another worker was first
                self.once.unlink()
                self._die()
        if values[0] > self.limit:
            self._die()
        return quadratic(values)

    def _die(self) -> None:
        if os.getpid() != self.parent:
            os.kill(os.getpid(), signal.SIGKILL)
