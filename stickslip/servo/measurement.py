"""Velocity from a log of encoder positions."""

from collections.abc import Mapping
from functools import cache

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]

CUTOFF = 117.0  # Low-pass of the measured velocity [Hz]


def smoothed(signal: Array, T_s: float, cutoff: float = CUTOFF) -> Array:
    """Return a log through a second-order Butterworth low-pass, forward and back: no phase lag.

    The signal (n,) has a value each T_s seconds. The cut-off is that of the single pass [Hz].
    """
    return scipy.signal.sosfiltfilt(_low_pass(cutoff, T_s), signal)


@cache
def _low_pass(cutoff: float, T_s: float) -> Array:
    """Return the second-order sections; designing them takes as long as filtering 10,000 values."""
    sections: Array = scipy.signal.butter(2, cutoff, fs=1.0 / T_s, output="sos")
    return sections


def derivative(signal: Array, T_s: float) -> Array:
    """Return the derivative (n,) of a smooth signal, of fourth order but at its ends."""
    slope = np.gradient(signal, T_s)
    slope[2:-2] = (signal[:-4] - 8.0 * signal[1:-3] + 8.0 * signal[3:-1] - signal[4:]) / (
        12.0 * T_s
    )
    return np.asarray(slope)


def measured_velocity(x_enc: Array, T_s: float) -> Array:
    """Return the velocity (n,) [m/s] from encoder positions (n,) [m]: differences, smoothed."""
    return smoothed(np.gradient(x_enc, T_s), T_s)


def blended_velocity(x_enc: Array, F_m: Array, m: float, T_s: float) -> Array:
    """Return the velocity (n,) [m/s] that the encoder shows below ``CUTOFF``, and the force above.

    Fast motion between two steps of an encoder, such as the response to one of them, shows in the
    force alone: above the cut-off it is its integral over the mass. The motor force F_m (n,) [N]
    acts in the period that ends at the position x_enc (n,) [m]; m is the mass [kg].
    """
    by_force = np.cumsum(F_m - F_m.mean()) * T_s / m
    return measured_velocity(x_enc, T_s) + by_force - smoothed(by_force, T_s)


def level(p: Mapping[str, float], v: Array | float) -> Array:
    """Return g (k,) [N] at velocities (k,) [m/s]; ``delta`` is the paper's 1 if not given.

    Without F_s, friction is F_c at each speed.
    """
    if "F_s" not in p:
        return np.full(np.shape(v), p["F_c"])
    return p["F_c"] + (p["F_s"] - p["F_c"]) * _rest(p, np.abs(v))


def _rest(p: Mapping[str, float], v: Array | float) -> Array:
    return np.asarray(np.exp(-((np.asarray(v) / p["v_s"]) ** p.get("delta", 1.0))))
