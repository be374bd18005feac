"""Output error: the measured position against that of the simulated loop with the candidate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from functools import lru_cache
from pathlib import Path
from typing import Self

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from stickslip.catalog.parameters import friction_law
from stickslip.catalog.space import ParameterSpace, Values
from stickslip.identification.criteria.closing import Closing
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_noise, position_of
from stickslip.identification.criteria.runs import RECENT
from stickslip.logs import Recording
from stickslip.models import Law
from stickslip.servo.measurement import Array

ORDER = 30
BURN_IN = 0.005
"""Share at the start of the recording that is not used: the controller's state is unknown."""


class OutputError(Closing):
    """Criterion: the measured position minus that of the simulated loop with the recorded command.

    Residuals can be whitened: encoder errors that have passed through the loop are predictable
    from one sample to the next.
    """

    name = "output error"

    def __init__(
        self,
        fmus: Path,
        recording: Recording,
        gains: Mapping[str, float],
        workers: int = 1,  # number of parallel runs
        law: Law | None = None,  # friction law of the drive FMU; LuGre by default
    ) -> None:
        self.space = ParameterSpace.of(law or friction_law())
        self.t = recording.t
        self.position = position_of(recording)
        self.loop = KnownLoop(fmus, recording, gains, workers=workers)
        # Whitening changes, but the positions that values give do not.
        self._simulated = lru_cache(RECENT)(self._simulate)
        self.noise = position_noise(self.position, recording.encoder_step)
        self.whitening = np.ones(1)
        self.used = slice(max(2 * ORDER, int(BURN_IN * len(self.t))), len(self.t))

    def raw(self, values: Values) -> Array:
        """Return measured minus simulated position (n,) [m]."""
        return np.asarray(self.position - self._simulated(tuple(values.items())))

    def _simulate(self, values: tuple[tuple[str, float], ...]) -> Array:
        return self.loop.run(dict(values))["candidate.x"]

    def residual(self, values: Values) -> Array:
        """Return the same, whitened (k,) [m]."""
        return self.white(self.raw(values))

    def map(self, points: Iterable[Values]) -> list[Array]:
        """Return the residuals of several points, ``workers`` at a time."""
        return self.loop.each(self.residual, points)

    def over(self, space: ParameterSpace) -> Self:
        """Return the same criterion over another space; it shares the FMUs."""
        other = copy(self)
        other.space = space
        return other

    def white(self, raw: Array) -> Array:
        """Whiten a residual (n,) and leave out its start, (k,)."""
        white = lfilter(self.whitening, [1.0], raw)[self.used]
        return np.asarray(white - white.mean())

    def whiten(self, values: Values) -> None:
        """Estimate the whitening filter from the residual of these values."""
        self.whitening = predictor_error(self.raw(values)[self.used], ORDER)

    def unexplained(self, values: Values, explained: Array) -> float:
        """Return the standard deviation of the residual over that of what is explained.

        Parameters
        ----------
        explained : (n,) residual [m] of these values' own recording, by encoder steps alone
        """
        expected = max(self.noise, float(np.std(explained[self.used])))
        return float(np.std(self.raw(values)[self.used])) / expected

    def close(self) -> None:
        """Free the FMUs."""
        self.loop.close()


def predictor_error(signal: Array, order: int) -> Array:
    """Return the filter (order + 1,) whose output is the one-step prediction error of a signal.

    Source: Yule and Walker; L. Ljung, System Identification, 2nd ed., chapter 4.
    """
    n = len(signal)
    correlation = np.array([signal[k:] @ signal[: n - k] for k in range(order + 1)]) / n
    if correlation[0] <= 0.0:
        return np.ones(1)
    correlation[0] *= 1.0 + 1e-4
    return np.append(1.0, -solve_toeplitz(correlation[:-1], correlation[1:]))
