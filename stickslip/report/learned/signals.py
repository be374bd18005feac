"""The signals of an estimation that the figures draw, and how many points they take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.identification.criteria.inverse_model import EDGE, SHARE
from stickslip.identification.criteria.motion import derivative, position_of
from stickslip.identification.estimation import Estimation
from stickslip.servo.measurement import Array
from stickslip.servo.stribeck_curve import level

FULLY_BENT = 5.0
"""Deflections F_s / sigma_0 after which bristles follow the Stribeck curve, nearly."""


@dataclass(frozen=True)
class Parts:
    """What the inverse model compares, without the ends that its low-pass spoils.

    Attributes
    ----------
    t : (k,) [s]
    position : (k,) [m]
    velocity : (k,) low-passed [m/s]
    measured, predicted : (k,) force [N]
    rest : (k,) the part of both that is not friction: inertia and offset [N]
    """

    t: Array
    position: Array
    velocity: Array
    measured: Array
    predicted: Array
    rest: Array

    @property
    def difference(self) -> Array:
        """Measured less predicted force (k,) [N]."""
        return self.measured - self.predicted


def parts(estimation: Estimation) -> Parts:
    """Return the signals of the inverse model."""
    figures, recording = estimation.figures, estimation.recording
    v = figures.velocity_recorded
    n = len(figures.t)
    edge = min(int(EDGE / SHARE) + 1, n // 10)
    used = slice(edge, n - edge)
    m = estimation.parameters["m"] if "m" in estimation.known else 0.0
    rest = m * derivative(v, recording.T_s) + estimation.parameters["F_0"]
    signals = (figures.t, position_of(recording), v, figures.measured, figures.predicted, rest)
    return Parts(*(np.asarray(signal[used]) for signal in signals))


def sliding(estimation: Estimation, signals: Parts) -> NDArray[np.bool_]:
    """Return where (k,) the displacement since the last reversal has bent the bristles fully."""
    v = signals.velocity
    path = np.cumsum(np.abs(v)) * estimation.recording.T_s
    turns = np.append(True, np.sign(v[1:]) != np.sign(v[:-1]))
    since = path - np.maximum.accumulate(np.where(turns, path, 0.0))
    p = estimation.parameters
    return np.asarray(since > FULLY_BENT * max(p["F_s"], p["F_c"]) / p["sigma_0"])


def measures_friction(estimation: Estimation) -> bool:
    """Tell whether friction itself was measured, not the motor's force."""
    return "m" not in estimation.known


def stribeck(estimation: Estimation, v: Array) -> Array:
    """Return friction (k,) [N] at constant velocities (k,) [m/s], viscous friction with it.

    Source
    ------
    Equations (4) and (5) of the paper.
    """
    p = estimation.parameters
    b = p["b"] if "b" in estimation.known else 0.0
    return np.asarray(np.sign(v) * level(p, v) + b * v)


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
    """Return at most ``most`` of n indices, evenly spaced."""
    return np.arange(0, n, max(1, -(-n // most)))
