"""Signals between their samples."""

from __future__ import annotations

from typing import Literal

import numpy as np
import scipy

from stickslip.servo.measurement import Array

MOST = 20_000  # number of samples on which the choice of an interpolation is based

Method = Literal["linear", "cubic"]


def better_method(t: Array, signal: Array) -> Method:
    """Return the method that predicts every other sample from its neighbours better.

    A cubic spline, nearly band-limited, for smooth signals; straight lines for commands with
    corners and for signals that are mostly noise or steps.

    Parameters
    ----------
    t : (n,) rising [s]
    signal : (n,)
    """
    t, signal = t[:MOST], signal[:MOST]
    if len(t) < 9:
        return "linear"
    known, asked = slice(0, None, 2), slice(3, len(t) - 3, 2)
    errors = {
        method: np.sum(
            (interpolated(t[known], signal[known], t[asked], method) - signal[asked]) ** 2
        )
        for method in ("linear", "cubic")
    }
    return "cubic" if errors["cubic"] < errors["linear"] else "linear"


def interpolated(t: Array, signal: Array, at: Array, method: str) -> Array:
    """Return a signal (n,) given at t (n,) at other times (k,) [s]."""
    if method == "cubic":
        return np.asarray(scipy.interpolate.CubicSpline(t, signal)(at))
    return np.interp(at, t, signal)
