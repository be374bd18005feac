"""Where two logs were recorded with the same command, whenever it began and in whatever order."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import correlate, correlation_lags, find_peaks

from stickslip.logs.grid import runs
from stickslip.servo.measurement import Array
from stickslip.thresholds import transfer

ROUNDING = 1e-4  # the same as a share of the largest speed in the log
NEAR = 0.1  # how far the largest speed near by is looked for [s]
LAGS = 20  # lags of the second log that are tried, of each kind


@dataclass(frozen=True)
class Overlap:
    """Samples of two logs with the same command: ``n`` from ``first`` and from ``second`` on."""

    first: int
    second: int
    n: int


def same_command(first: Array, second: Array, T_s: float) -> list[Overlap]:
    """Return the stretches in which two velocity commands (n,), (k,) [m/s] are the same."""
    least = max(2, round(transfer.STRETCH / T_s))
    free = np.ones(len(first), dtype=bool), np.ones(len(second), dtype=bool)
    found: list[Overlap] = []
    lags = _lags(first, second)
    while True:
        candidates = [list(_runs(first, second, lag, free, T_s=T_s, least=least)) for lag in lags]
        motion = [sum(_motion(first, run) for run in several) for several in candidates]
        if not motion or not max(motion):
            return sorted(found, key=lambda run: run.first)
        for run in candidates[int(np.argmax(motion))]:
            found.append(run)
            free[0][run.first : run.first + run.n] = False
            free[1][run.second : run.second + run.n] = False


def is_moving(command: Array) -> NDArray[np.bool_]:
    """Return where (n,) a velocity command moves the drive."""
    return np.asarray(np.abs(command) > transfer.MOVING * np.max(np.abs(command), initial=0.0))


def period(command: Array, T_s: float) -> int | None:
    """Return after how many samples a velocity command (n,) repeats itself to its end, or None."""
    n = len(command)
    everywhere = np.ones(n, dtype=bool)
    lags, difference = _difference(command, command)
    for k in find_peaks(-difference)[0]:
        lag = int(lags[k])
        if not transfer.STRETCH / T_s < lag <= n / 2:
            continue
        found = list(_runs(command, command, lag, (everywhere, everywhere), T_s=T_s, least=1))
        if [run.n for run in found] == [n - lag]:
            return lag
    return None


def _lags(first: Array, second: Array) -> list[int]:
    """Return by how many samples the second may be ahead of the first, likely ones first.

    Where much is in common the mean square difference has a minimum. Where other parts hide it, the
    correlation of the commands or of their accelerations has a peak.
    """
    lags, difference = _difference(first, second)
    found = _highest(-difference, lags)
    for one, other in ((np.diff(first), np.diff(second)), (first, second)):
        correlation = correlate(one, other, method="fft")
        found += _highest(correlation, correlation_lags(len(one), len(other)))
    return list(dict.fromkeys(found))


def _highest(values: Array, lags: NDArray[np.intp]) -> list[int]:
    """Return the lags of the highest peaks of values (n,)."""
    peaks = find_peaks(np.concatenate([[-np.inf], values, [-np.inf]]))[0] - 1
    best = peaks[np.argsort(-values[peaks], kind="stable")][:LAGS]
    return [int(lags[k]) for k in best]


def _difference(first: Array, second: Array) -> tuple[NDArray[np.intp], Array]:
    """Return lags, and the commands' mean square difference at each, relative to their own."""
    lags = correlation_lags(len(first), len(second))
    product, own, other, count = (
        correlate(a, b, method="fft")
        for a, b in (
            (first, second),
            (first**2, np.ones_like(second)),
            (np.ones_like(first), second**2),
            (np.ones_like(first), np.ones_like(second)),
        )
    )
    energy = own + other
    moved = (energy > 1e-6 * np.max(energy)) & (count > 1.5)
    relative = (energy - 2.0 * product) / np.where(moved, energy, 1.0)
    return lags, np.where(moved, relative, 1.0)


def _runs(
    first: Array,
    second: Array,
    lag: int,
    free: tuple[NDArray[np.bool_], NDArray[np.bool_]],
    T_s: float,
    least: int,
) -> Iterator[Overlap]:
    """Yield the stretches in which second[i] is first[i + lag], and the drive is moved."""
    begin = max(0, lag)
    n = min(len(first), len(second) + lag) - begin
    if n < least:
        return
    one, other = slice(begin, begin + n), slice(begin - lag, begin - lag + n)
    a, b = first[one], second[other]
    reach = 2 * max(1, round(NEAR / T_s)) + 1
    tolerance = transfer.SAME * maximum_filter1d(np.abs(a), reach)
    tolerance = tolerance + ROUNDING * np.max(np.abs(first))
    # A sample more or less: the logs are not sampled at the same instants of the command.
    same = (b <= maximum_filter1d(a, 3) + tolerance) & (b >= minimum_filter1d(a, 3) - tolerance)
    same &= free[0][one] & free[1][other]
    for left, right in runs(same):
        run = Overlap(begin + left, begin - lag + left, right - left)
        if run.n >= least and _motion(first, run):
            yield run


def _motion(command: Array, run: Overlap) -> int:
    """Return in how many samples of a stretch the command moves the drive."""
    return int(np.sum(is_moving(command)[run.first : run.first + run.n]))
