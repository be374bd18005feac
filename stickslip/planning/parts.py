"""The parts of an experiment: velocities (n,) that start and end at 0 and lead back.

Each is a function (limits, n) of n samples; the first one is 0, the one after the last would be.
"""

from __future__ import annotations

import math

import numpy as np

from stickslip.planning.limits import Limits
from stickslip.servo.measurement import Array

QUICK = 0.1
"""Shortest move [s]: what most position loops still follow."""


def small_moves(limits: Limits, n: int) -> Array:
    """Return small moves out and back, from the smallest to the largest; each slow, then quick.

    Within the presliding range the slow ones show stiffness, the quick ones damping. How far that
    range goes nobody knows beforehand, so their sizes are a geometric series.
    """
    moves = max(4, round(n / limits.rate / 0.3))
    smallest, largest = limits.presliding
    sizes = np.geomspace(smallest, max(smallest, min(largest, limits.stroke / 4)), moves)
    pieces = []
    for size, room in zip(sizes, _shares(n, moves), strict=True):
        quick = min(room // 2, max(2, round(QUICK * limits.rate)))
        pieces += [
            _move(limits, math.pi * size * limits.rate / samples, samples)
            for samples in (room - quick, quick)
        ]
    return np.concatenate(pieces)


def slow_reversals(limits: Limits, n: int) -> Array:
    """Return sines of velocity, the fastest of the slow speeds first: the Stribeck region.

    Slow ones break away only where a loop's integrator already holds most of the friction.
    """
    count = max(3, round(n / limits.rate))
    slowest, fastest = limits.slow
    speeds = np.geomspace(fastest, slowest, count)
    return np.concatenate(
        [_move(limits, v, room) for v, room in zip(speeds, _shares(n, count), strict=True)]
    )


def constant_speeds(limits: Limits, n: int) -> Array:
    """Return trapezoids forward and back at speeds in a geometric series."""
    count = max(2, round(n / limits.rate / 1.0))
    speeds = np.geomspace(limits.speed, min(limits.slow[1], limits.speed), count)
    pieces = []
    for v, samples in zip(speeds, _shares(n, count), strict=True):
        share = np.arange(samples) / samples
        shape = np.interp(share, [0, 0.1, 0.4, 0.6, 0.9, 1], [0, 1, 1, -1, -1, 0])
        pieces.append(bounded(v * shape, limits))
    return np.concatenate(pieces)


def quick_ramps(limits: Limits, n: int) -> Array:
    """Return triangles of velocity, at nine tenths of the permitted acceleration."""
    a = 0.9 * limits.acceleration
    period = max(QUICK, 4 * limits.speed / a)
    count = max(1, math.floor(n / limits.rate / period))
    pieces = []
    for samples in _shares(n, count):
        quarter = samples / limits.rate / 4
        shape = np.interp(np.arange(samples) / samples, [0, 0.25, 0.75, 1], [0, 1, -1, 0])
        pieces.append(bounded(min(limits.speed, a * quarter) * shape, limits))
    return np.concatenate(pieces)


def sweep(limits: Limits, n: int) -> Array:
    """Return a sine of rising frequency, its amplitude from three quarters of the speed to all.

    Its range of frequencies narrows to what stroke and acceleration permit.
    """
    stroke, a = limits.stroke, 0.9 * limits.acceleration
    top = min(limits.speed, math.sqrt(a * stroke) / 2)
    first = max(limits.frequency[0], 0.75 * top / (math.pi * stroke))
    last = max(first, min(limits.frequency[1], a / (2 * math.pi * top), limits.rate / 20))
    duration = n / limits.rate
    cycles = max(1, math.floor(0.5 * (first + last) * duration))  # whole ones, to end at 0
    last = max(first, 2 * cycles / duration - first)
    share = np.arange(n) / n
    phase = first * duration * share + (cycles - first * duration) * share**2
    values = top * (0.75 + 0.25 * share) * np.sin(2 * math.pi * phase)
    return bounded(_closed(values), limits)


def bounded(v: Array, limits: Limits) -> Array:
    """Return a velocity made so much smaller that it keeps the limits."""
    x = np.cumsum(v) / limits.rate
    slope = np.abs(np.diff(v, append=0.0)).max() * limits.rate
    most = np.array([np.abs(v).max(), slope, np.ptp(x)])
    allowed = np.array([limits.speed, limits.acceleration, 0.95 * limits.stroke])
    with np.errstate(divide="ignore"):
        return v * np.float64(min(1.0, np.min(allowed / most)))


def _move(limits: Limits, v: float, samples: int) -> Array:
    """Return one sine of velocity: out and back."""
    return bounded(v * np.sin(2 * math.pi * np.arange(samples) / samples), limits)


def _closed(v: Array) -> Array:
    """Return a velocity that leads back: what is missing is spread over the whole."""
    window = np.sin(math.pi * np.arange(len(v)) / len(v)) ** 2
    return np.asarray(v - window * (v.sum() / window.sum()))


def _shares(n: int, count: int) -> list[int]:
    """Split n samples into ``count`` nearly equal shares."""
    edges = np.linspace(0, n, count + 1).round().astype(int)
    return [int(share) for share in np.diff(edges)]
