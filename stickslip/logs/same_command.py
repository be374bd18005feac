"""Where two logs were recorded with the same command, whenever it began."""

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
    """Return the stretches in which two velocity commands (n,), (k,) [m/s] are the same.

    They are those of the lag with the most motion in common, of the lags at which the correlation
    of the commands or of their accelerations is highest.
    """
    least = max(2, round(transfer.STRETCH / T_s))
    best, most = list[Overlap](), 0
    for one, other in ((np.diff(first), np.diff(second)), (first, second)):
        values = correlate(one, other, method="fft")
        lags = correlation_lags(len(one), len(other))
        peaks = find_peaks(np.concatenate([[-np.inf], values, [-np.inf]]))[0] - 1
        for k in peaks[np.argsort(-values[peaks], kind="stable")][:LAGS]:
            found = [run for run in _runs(first, second, int(lags[k]), T_s) if run.n >= least]
            motion = sum(_motion(first, run) for run in found)
            if motion > most:
                best, most = [run for run in found if _motion(first, run)], motion
    return best


def is_moving(command: Array) -> NDArray[np.bool_]:
    """Return where (n,) a velocity command moves the drive."""
    return np.asarray(np.abs(command) > transfer.MOVING * np.max(np.abs(command), initial=0.0))


def _runs(first: Array, second: Array, lag: int, T_s: float) -> Iterator[Overlap]:
    """Yield the stretches in which second[i] is first[i + lag]."""
    begin = max(0, lag)
    n = max(min(len(first), len(second) + lag) - begin, 0)
    a, b = first[begin : begin + n], second[begin - lag : begin - lag + n]
    reach = 2 * max(1, round(NEAR / T_s)) + 1
    tolerance = transfer.SAME * maximum_filter1d(np.abs(a), reach)
    tolerance = tolerance + ROUNDING * np.max(np.abs(first))
    # A sample more or less: the logs are not sampled at the same instants of the command.
    same = (b <= maximum_filter1d(a, 3) + tolerance) & (b >= minimum_filter1d(a, 3) - tolerance)
    for left, right in runs(same):
        yield Overlap(begin + left, begin - lag + left, right - left)


def _motion(command: Array, run: Overlap) -> int:
    """Return in how many samples of a stretch the command moves the drive."""
    return int(np.sum(is_moving(command)[run.first : run.first + run.n]))
