"""Standard functions of optimisation, with a lowest point that follows a seed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from cma import ff

from stickslip import ga


def ackley(z: np.ndarray) -> float:
    wide = 20 * np.exp(-0.2 * np.sqrt(np.mean(z**2)))
    return float(20 + np.e - wide - np.exp(np.mean(np.cos(2 * np.pi * z))))


@dataclass(frozen=True)
class Function:
    """A function of z (k,) that is 0 at the origin, and where that lies in a box."""

    value: Callable[[np.ndarray], float]
    lower: float  # end of the box of x, the same for each gene
    upper: float
    rotated: bool = False  # z is x less its lowest point, rotated


class Instance:
    """A function in k dimensions whose lowest point, start and rotation follow a seed."""

    def __init__(self, function: Function, k: int, seed: int) -> None:
        rng = np.random.default_rng([seed, k])
        self._function = function
        span = function.upper - function.lower
        start = function.lower + span * rng.random(k)
        self._lowest = function.lower + span * rng.uniform(0.2, 0.8, k)
        self._turn = np.eye(k)
        if function.rotated:
            self._turn = np.linalg.qr(rng.standard_normal((k, k)))[0]
        ends = float(function.lower), float(function.upper)
        genes = [ga.Gene(f"x{i}", *ends, float(x), linear=True) for i, x in enumerate(start)]
        self.problem = ga.Problem(genes)

    def __call__(self, x: np.ndarray) -> float:
        """Evaluate x, shape (k,); 0 or above."""
        return max(0.0, float(self._function.value(self._turn.T @ (x - self._lowest))))


STANDARD = {
    "ellipsoid, rotated": Function(ff.elli, -5, 5, rotated=True),
    "Ackley, rotated": Function(ackley, -32.768, 32.768, rotated=True),
    "Rastrigin": Function(ff.rastrigin, -5.12, 5.12),
    "Rastrigin, rotated": Function(ff.rastrigin, -5.12, 5.12, rotated=True),
}
