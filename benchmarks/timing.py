"""Times that can be compared: one process, case after case in turn, medians; and their table."""

import statistics
import time
from collections.abc import Callable, Mapping


def interleaved(
    cases: Mapping[str, Callable[[], object]],
    repeats: int,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Return the median seconds of each case; every repeat runs all cases once.

    What runs in one thread is best measured by ``time.thread_time``, which other processes disturb
    little.
    """
    times: dict[str, list[float]] = {name: [] for name in cases}
    for run in cases.values():
        run()
    for _ in range(repeats):
        for name, run in cases.items():
            begin = clock()
            run()
            times[name].append(clock() - begin)
    return {name: statistics.median(seconds) for name, seconds in times.items()}


def table(figures: Mapping[str, float]) -> str:
    """Return a line for each figure."""
    return "\n".join(f"  {name:76} {figure:8.4g}" for name, figure in figures.items())
