"""The step in which a signal was logged."""

from __future__ import annotations

import numpy as np

from stickslip.servo.measurement import Array

DIVISORS = 12
"""The smallest difference seen may be up to so many steps."""
SHARE = 0.98
"""Of the differences must be whole steps."""


def step_of(signal: Array) -> float:
    """Return the step of which all differences of a signal (n,) are multiples; 0 when none shows.

    Differences below what doubles can hold at the signal's size count as none. A signal that was
    filtered, or written with all its digits, has no step.
    """
    differences = np.abs(np.diff(signal[np.isfinite(signal)]))
    if not len(differences):
        return 0.0
    floor = 256 * np.finfo(float).eps * float(np.max(np.abs(signal[np.isfinite(signal)])))
    differences = np.sort(differences[differences > floor])
    if len(differences) < 10:
        return 0.0
    smallest = float(differences[len(differences) // 100])
    near = differences[differences < 1.02 * smallest]
    for divisor in range(1, DIVISORS + 1):
        step = _refined(differences, float(np.median(near)) / divisor)
        counts = differences / step
        whole = np.abs(counts - np.round(counts)) < 0.05 + floor / step
        if step > 4 * floor and np.mean(whole & (counts > 0.5)) >= SHARE:
            return step
    return 0.0


def _refined(differences: Array, step: float) -> float:
    """Return a step fitted to ever larger differences."""
    for most in (3, 30, 300):
        counts = np.round(differences / step)
        some = (counts > 0) & (counts <= most)
        if some.any():
            step = float(differences[some] @ counts[some] / (counts[some] @ counts[some]))
    return step
