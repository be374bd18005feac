"""Where a residual stands out from what it is elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.servo.measurement import Array

WINDOW = 0.05  # In which the largest value counts [s]
USUAL = 0.9  # Share of the windows whose largest value is usual
OUT = 2.0  # Ratio to the largest usual value from which one stands out; that of noise is about 1.3


@dataclass(frozen=True)
class Stretch:
    """A stretch of time in which a residual stands out."""

    # [s]
    begin: float
    end: float
    peak: float  # value of the largest magnitude, in the unit of the residual
    ratio: float  # of its magnitude to the largest usual one
    speed: float  # in its middle, in the unit of the velocity


def stretches(t: Array, residual: Array, velocity: Array) -> list[Stretch]:
    """Return where a residual (n,) stands out, the largest first; t (n,) [s] is even."""
    n = max(round(WINDOW / (t[1] - t[0])), 1)
    windows = [slice(k, k + n) for k in range(0, len(t), n)]
    peaks = np.array([np.abs(residual[of]).max() for of in windows])
    usual = float(np.quantile(peaks, USUAL))
    out = np.flatnonzero(peaks > OUT * usual)
    found = []
    for run in np.split(out, np.flatnonzero(np.diff(out) > 1) + 1):
        if len(run) and usual > 0.0:
            begin, end = windows[run[0]].start, min(windows[run[-1]].stop, len(t))
            peak = begin + int(np.abs(residual[begin:end]).argmax())
            found.append(
                Stretch(
                    *(float(t[begin]), float(t[end - 1]), float(residual[peak])),
                    ratio=float(abs(residual[peak])) / usual,
                    speed=abs(float(velocity[peak])),
                )
            )
    return sorted(found, key=lambda one: -one.ratio)
