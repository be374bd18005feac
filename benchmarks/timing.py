"""Times that can be compared: one process, case after case in turn, medians; and their table."""

import statistics
import time
from collections.abc import Callable, Mapping


def interleaved(cases: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Return the median seconds of each case; every repeat runs all cases once."""
    times: dict[str, list[float]] = {name: [] for name in cases}
    for run in cases.values():
        run()
    for _ in range(repeats):
        for name, run in cases.items():
            begin = time.perf_counter()
            run()
            times[name].append(time.perf_counter() - begin)
    return {name: statistics.median(seconds) for name, seconds in times.items()}


def table(figures: Mapping[str, float]) -> str:
    """Return a line for each figure."""
    return "\n".join(f"  {name:76} {figure:8.4g}" for name, figure in figures.items())
