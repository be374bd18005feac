"""Costs that pickle, for the tests."""

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
