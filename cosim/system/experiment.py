"""When a run starts and stops, and its step."""

from __future__ import annotations

import math
import os
from numbers import Real

from stickslip.cosim.errors import ExperimentError

MAX_STEPS = 10**10
_SHARE = 0.8  # of a machine's memory that a run may take
_NUMBER = 8  # bytes


def count_steps(start: float, stop: float, step: float) -> int:
    """Return how many steps lead from start to stop (all in s)."""
    for name, value in (("start", start), ("stop", stop), ("step", step)):
        if not isinstance(value, Real):
            raise ExperimentError(f"{name} is {value!r:.80}, expected a number, in s")
    if not (all(map(math.isfinite, (start, stop, step))) and step > 0 and stop > start):
        raise ExperimentError(
            f"start {start} s, stop {stop} s and step {step} s must be finite, the step must be"
            " positive, and stop must lie after start"
        )
    exact = (stop - start) / step
    if exact > MAX_STEPS:
        raise ExperimentError(
            f"a step of {step} s makes {exact:.3g} steps of the interval {start} to {stop} s, at"
            f" most {MAX_STEPS:.0e} are done; choose a larger step or an earlier stop"
        )
    if 4 * math.ulp(max(abs(start), abs(stop))) > step:
        raise ExperimentError(
            f"a step of {step} s is lost in rounding at times of {stop:.9g} s; choose a larger one"
        )
    n = round(exact)
    rounding = math.ulp(max(abs(start), abs(stop))) / step
    if n < 1 or abs(exact - n) > 1e-9 * n + rounding:
        raise ExperimentError(
            f"a step of {step} s does not divide the interval {start} to {stop} s:"
            f" it holds {exact:.9g} steps; choose a stop of {start + max(1, n) * step:.9g} s"
        )
    return n


def check_memory(points: int, columns: float) -> None:
    """Check that a machine has room for what a run keeps.

    Parameters
    ----------
    points : in time
    columns : numbers that are kept of each
    """
    try:
        present = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError):  # not on Windows
        return
    needed = points * columns * _NUMBER
    if needed > _SHARE * present:
        raise ExperimentError(
            f"the run would keep {points:.3g} points of {columns:.3g} numbers: {needed / 1e9:.3g}"
            f" GB, where the machine has {present / 1e9:.3g} GB; record less, fewer points or a"
            " shorter time"
        )


def check_tolerance(tolerance: float | None) -> None:
    """Check a relative tolerance of solvers."""
    if tolerance is not None and not 0 < tolerance < 1:
        raise ExperimentError(f"tolerance is {tolerance}, expected a number between 0 and 1")
