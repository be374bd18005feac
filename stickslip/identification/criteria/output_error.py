"""Output error: the position that the known loop shows with a candidate in it, against the log."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from stickslip.identification.criteria.closing import Closing
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.criteria.unknowns import Values
from stickslip.logs import Recording
from stickslip.servo.measurement import Array

ORDER = 30
BURN_IN = 0.005
"""Share of the recording at its begin that does not count: the controller's state is unknown."""


class OutputError(Closing):
    """Judges values by the position that follows from the recorded command.

    Residuals can be whitened: the encoder's errors went around the loop, and what is left of them
    is predictable from one sample to the next.

    Parameters
    ----------
    workers : how many runs go on side by side
    """

    name = "output error"

    def __init__(
        self, fmus: Path, recording: Recording, gains: Mapping[str, float], workers: int = 1
    ) -> None:
        self.t = recording.t
        self.position = position_of(recording)
        self.loop = KnownLoop(fmus, recording, gains, workers=workers)
        self.each = self.loop.each
        self.whitening = np.ones(1)
        self.used = slice(max(2 * ORDER, int(BURN_IN * len(self.t))), len(self.t))

    def raw(self, values: Values) -> Array:
        """Return recorded without simulated position (n,) [m]."""
        return np.asarray(self.position - self.loop.run(values)["candidate.x"])

    def residual(self, values: Values) -> Array:
        """Return the same, whitened (k,) [m]."""
        return self.white(self.raw(values))

    def white(self, raw: Array) -> Array:
        """Whiten a residual (n,) and leave out the begin, (k,)."""
        white = lfilter(self.whitening, [1.0], raw)[self.used]
        return np.asarray(white - white.mean())

    def whiten(self, values: Values) -> None:
        """Learn from the residual of these values how it is predictable."""
        self.whitening = predictor_error(self.raw(values)[self.used], ORDER)

    def close(self) -> None:
        """Free the FMUs."""
        self.loop.close()


def predictor_error(signal: Array, order: int) -> Array:
    """Return the filter (order + 1,) whose output is what the signal's past does not predict.

    Source
    ------
    Yule and Walker; L. Ljung, System Identification, 2nd ed., chapter 4.
    """
    n = len(signal)
    correlation = np.array([signal[k:] @ signal[: n - k] for k in range(order + 1)]) / n
    if correlation[0] <= 0.0:
        return np.ones(1)
    correlation[0] *= 1.0 + 1e-4
    return np.append(1.0, -solve_toeplitz(correlation[:-1], correlation[1:]))
