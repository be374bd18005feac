"""Sweeps of the ring: where short runs are evaluated, CPU time of all processes (Linux)."""

import os
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from distributed import LocalCluster

import stickslip as ss
from benchmarks.common import cpu, interleaved
from benchmarks.coupling import ring

RUNS, STEPS, REPEATS = 1000, 1000, 5
WHERE = ("threads", "processes", "dask")


def measure(folder: Path) -> dict[str, float]:
    """Return the start, the cost of a run, and ratios: the least of sweeps that take turns.

    The first sweep in processes also starts the server that forks them, once for a program.
    """
    system = ring.system(folder, 2)
    options: dict[str, Any] = {"stop": STEPS * ring.STEP, "step": ring.STEP, "isolation": None}

    def sweep(where: str, runs: int) -> Any:
        gains = {"controller.K_p": [40.0 + 0.01 * k for k in range(runs)]}
        figures = {"end": lambda run: run["mass.v"][-1], "most": lambda run: run["mass.v"].max()}
        with ExitStack() as stack:
            place = where
            if where == "dask":
                started = LocalCluster(2, threads_per_worker=1, dashboard_address=":0")
                place = stack.enter_context(started).scheduler_address
            return ss.sweep(system, gains, figures, where=place, workers=2, **options)

    cases = {
        f"{where} {runs}": lambda where=where, runs=runs: sweep(where, runs)
        for where in WHERE
        for runs in (2, RUNS)
    }
    sweep("threads", 2)
    begin = _cpu()
    sweep("processes", 2)
    found = {"processes: first start and 2 runs (s)": _cpu() - begin}
    seconds = interleaved(cases, REPEATS, _cpu, min)
    for where in WHERE:
        start, whole = seconds[f"{where} 2"], seconds[f"{where} {RUNS}"]
        found[f"{where}: start and 2 runs (s)"] = start
        found[f"{where}: {RUNS} runs (s)"] = whole
        found[f"{where}: {RUNS} runs / threads"] = whole / seconds[f"threads {RUNS}"]
        found[f"{where}: a run after the start (ms)"] = 1e3 * (whole - start) / (RUNS - 2)
    return found


def _cpu() -> float:
    """Return the CPU seconds of this process, and of its children with all that have ended."""
    ticks = 0
    for file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended
            fields = file.read_text().rpartition(")")[2].split()  # see proc_pid_stat(5), from 3 on
            ticks += sum(map(int, fields[11:15])) if int(fields[1]) == os.getpid() else 0
    return cpu() + ticks / os.sysconf("SC_CLK_TCK")
