"""Sweeps of the ring: where short runs are evaluated, CPU time of all processes."""

from pathlib import Path
from typing import Any

import stickslip as ss
from benchmarks.common import cpu, interleaved
from benchmarks.coupling import ring

RUNS, STEPS, REPEATS = 1000, 1000, 5
WHERE = {"threads": 2, "processes": 2, "local": 2}  # and how many workers; local: Dask


def measure(folder: Path) -> dict[str, float]:
    """Return the start, the cost of a run, and ratios: the least of sweeps that take turns."""
    system = ring.system(folder, 2)
    options: dict[str, Any] = {"stop": STEPS * ring.STEP, "step": ring.STEP, "isolation": None}

    def sweep(where: str, runs: int) -> Any:
        gains = {"controller.K_p": [40.0 + 0.01 * k for k in range(runs)]}
        figures = {"end": lambda run: run["mass.v"][-1], "most": lambda run: run["mass.v"].max()}
        return ss.sweep(system, gains, figures, where=where, workers=WHERE[where], **options)

    cases = {
        f"{where} {runs}": lambda where=where, runs=runs: sweep(where, runs)
        for where in WHERE
        for runs in (2, RUNS)
    }
    seconds = interleaved(cases, REPEATS, cpu, min)
    found = {}
    for where in WHERE:
        start, whole = seconds[f"{where} 2"], seconds[f"{where} {RUNS}"]
        found[f"{where}: start and 2 runs (s)"] = start
        found[f"{where}: {RUNS} runs (s)"] = whole
        found[f"{where}: {RUNS} runs / threads"] = whole / seconds[f"threads {RUNS}"]
        found[f"{where}: a run after the start (ms)"] = 1e3 * (whole - start) / (RUNS - 2)
    return found
