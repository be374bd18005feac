"""Long signals with as many points as a picture can show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.servo.measurement import Array

COLUMNS = 700
"""More than a printed page's width resolves."""


def thinned(t: Array, signal: Array, columns: int = COLUMNS) -> tuple[Array, Array]:
    """Return the least and the largest value of each stretch of time, in their order.

    Parameters
    ----------
    t, signal : (n,) of any length
    columns : so many stretches; a signal of at most two values each stays as it is

    Returns
    -------
    two arrays of at most 2 columns values, which draw the same line
    """
    if len(t) <= 2 * columns:
        return t, signal
    kept = []
    for stretch in np.array_split(np.arange(len(t)), columns):
        ends = (stretch[np.argmin(signal[stretch])], stretch[np.argmax(signal[stretch])])
        kept += sorted(set(ends))
    return t[kept], signal[kept]


def spread(n: int, most: int) -> NDArray[np.intp]:
    """Return at most so many of n indices, evenly."""
    return np.arange(0, n, max(1, -(-n // most)))
