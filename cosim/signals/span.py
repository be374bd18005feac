"""Spans of time, and when two times are the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim.errors import SignalError


def slack(t: Any, step: float) -> Any:
    """Return how far from times t (s) another may lie that is meant to be the same, in s.

    A millionth of the step of the run, or the next number that a computer has: at large times, such
    as those of a clock that counts from 1970, that is more.
    """
    return 1e-6 * step + np.spacing(np.abs(t))


@dataclass(frozen=True)
class Span:
    """From ``begin`` up to, not including, ``end`` (s).

    Raises
    ------
    SignalError
        When it is empty.
    """

    begin: float
    end: float

    def __post_init__(self) -> None:
        if not self.begin < self.end:
            raise SignalError(f"from {self.begin} s to {self.end} s: expected begin before end")

    def covers(self, time: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which of the points in time (n,) of a run lie in it, (n,)."""
        near: NDArray[np.float64]
        near = slack(time, float(time[-1] - time[0]) / max(1, len(time) - 1))
        return (time >= self.begin - near) & (time < self.end - near)
