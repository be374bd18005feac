"""Estimates with standard errors that know how correlated residuals are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A value and its standard error, both in the parameter's unit."""

    value: float
    standard_error: float


LOW, HIGH = "_low", "_high"
"""What the columns of a range are called behind the name of their median."""
UNKNOWN = 3.0  # relative standard error of a value that no experiment showed: a factor of e^3


def unseen(value: float) -> Estimate:
    """Return a start value that no experiment showed."""
    return Estimate(value, UNKNOWN * value)


def correlation_length(residual: Array) -> float:
    """Return how many neighbouring samples say the same: 1 for white noise.

    The sum of the autocorrelation up to its first value below 0.05, both sides.
    """
    centred = residual - residual.mean()
    power = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
    correlation = np.fft.irfft(power)[: len(centred)]
    if correlation[0] <= 0.0:
        return 1.0
    correlation /= correlation[0]
    below = np.flatnonzero(correlation < 0.05)
    end = below[0] if len(below) else len(correlation)
    return float(1.0 + 2.0 * correlation[1:end].sum())


def covariance(jacobian: Array, residual: Array) -> Array:
    """Return the covariance (k, k) of a least-squares fit.

    The Jacobian (n, k) is that of the residual (n,), both at the fit.
    """
    n, k = jacobian.shape
    variance = residual @ residual / max(n - k, 1) * correlation_length(residual)
    return np.asarray(variance * np.linalg.pinv(jacobian.T @ jacobian))
