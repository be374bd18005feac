"""The matrix exponential, without the 1: a slow mode keeps its digits beside a fast one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def exponential(matrix: Array) -> Array:
    """Return e^matrix - 1, (n, n): what ``continuous.c`` does."""
    norm = float(np.abs(matrix).sum(axis=1).max(initial=0.0))
    squarings = max(0, math.ceil(math.log2(norm / 0.5))) if norm > 0.0 else 0
    part = matrix / 2.0**squarings
    series = np.eye(len(matrix))
    for n in range(14, 1, -1):
        series = np.eye(len(matrix)) + part @ series / n
    result = part @ series
    for _ in range(squarings):
        result = 2.0 * result + result @ result
    return np.asarray(result)
