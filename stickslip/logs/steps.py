"""Steps of which the numbers in a column are multiples: of an encoder, or of a clock."""

from __future__ import annotations

import numpy as np

from stickslip.servo.measurement import Array

DIVISORS = 12  # most encoder steps that the smallest difference of a signal may have
SHARE = 0.98  # share of the differences that must be whole steps


def step_of(signal: Array) -> float:
    """Return the step of which all differences of a signal (n,) are multiples; 0 if there is none.

    Differences within the rounding of doubles at the size of the signal are ignored. A filtered
    signal, or one with all its digits, has no step.
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
    """Return a step fitted to larger and larger differences."""
    for most in (3, 30, 300):
        counts = np.round(differences / step)
        some = (counts > 0) & (counts <= most)
        if some.any():
            step = float(differences[some] @ counts[some] / (counts[some] @ counts[some]))
    return step


def clock_step(t: Array) -> float:
    """Return the step of which all differences of times (n,) are multiples; 0 if there is none.

    The step of times in single precision is at least the spacing of the largest.
    """
    single = t.astype(np.float32)
    spacing = np.spacing(np.abs(single)).astype(np.float64)
    least = float(spacing.max()) if np.all(np.abs(t - single) < 0.05 * spacing) else 0.0
    floor = 8 * np.finfo(float).eps * float(np.max(np.abs(t)))
    differences = np.unique(np.abs(np.diff(t)))
    differences = differences[differences > floor]
    step = float(differences.min(initial=np.inf))
    while 100.0 * floor < step < np.inf:  # Euclid's algorithm
        rest = np.abs(differences - step * np.round(differences / step))
        rest = rest[rest > floor * (1.0 + differences / step)]
        if not rest.size:
            return max(step, least)
        step = float(rest.min())
    return least
