"""When a run starts and stops, and its step."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cosim.errors import ExperimentError


@dataclass(frozen=True)
class DefaultExperiment:
    """What an FMU or an SSP proposes. All times in s; None where it proposes nothing.

    ``tolerance`` is the relative one of solvers.
    """

    start: float | None = None
    stop: float | None = None
    step: float | None = None
    tolerance: float | None = None


def count_steps(start: float, stop: float, step: float) -> int:
    """Return how many steps lead from start to stop (all in s).

    Raises
    ------
    ExperimentError
        When a time is not finite, the interval or the step is not positive, or the step does not
        divide the interval.
    """
    if not all(map(math.isfinite, (start, stop, step))):
        raise ExperimentError(f"start {start} s, stop {stop} s and step {step} s must be finite")
    if step <= 0 or stop <= start:
        raise ExperimentError(
            f"the step ({step} s) must be positive and stop ({stop} s) lie after start ({start} s)"
        )
    exact = (stop - start) / step
    n = round(exact)
    if n < 1 or abs(exact - n) > 1e-9 * n:
        raise ExperimentError(
            f"a step of {step} s does not divide the interval {start} .. {stop} s:"
            f" it holds {exact:.9g} steps; choose a stop of {start + max(1, n) * step:.9g} s"
        )
    return n


def check_tolerance(tolerance: float | None) -> None:
    """Check a relative tolerance of solvers.

    Raises
    ------
    ExperimentError
        When it is no number between 0 and 1.
    """
    if tolerance is not None and not 0 < tolerance < 1:
        raise ExperimentError(f"tolerance is {tolerance}, expected a number between 0 and 1")
