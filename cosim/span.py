"""A span of time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Span:
    """From ``begin`` up to, not including, ``end`` (s)."""

    begin: float
    end: float

    def covers(self, time: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which of the points in time (n,) of a run lie in it, (n,)."""
        # a time that is meant to be a point of the run may miss it by a rounding error
        slack = 1e-9 * max(1e-300, float(time[-1] - time[0])) / max(1, len(time) - 1)
        return (time >= self.begin - slack) & (time < self.end - slack)
