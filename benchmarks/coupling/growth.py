"""How the cost grows: with FMUs, with variables of each FMU, with steps; and two threads."""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.coupling import ring
from benchmarks.timing import interleaved

FMUS = (3, 30, 300, 3000)
VARIABLES = (1, 10, 100, 1000)
STEPS = (1_000, 10_000, 100_000, 1_000_000)


def by_fmus(folder: Path, version: int, coupling: str) -> dict[int, float]:
    """Return ns per FMU and step: the difference of two runs, so without start and end."""
    return {
        n: _per_step(ring.system(folder, version, n), max(32, 60_000 // n), coupling) / n
        for n in FMUS
    }


def by_variables(folder: Path) -> dict[int, float]:
    """Return ns per FMU and step with so many recorded outputs more on each FMU."""
    return {
        n: _per_step(ring.system(folder, 2, 3, n), 200_000 // (n + 50), "jacobi", None) / 3
        for n in VARIABLES
    }


def by_steps(folder: Path) -> dict[int, float]:
    """Return ns per FMU and step of a whole run, start and end included."""
    system = ring.system(folder, 2)
    costs = {}
    for n in STEPS:
        seconds = interleaved({"run": _prepare(system, n, "jacobi").run}, 11, time.thread_time)
        costs[n] = seconds["run"] / n / 3 * 1e9
    return costs


def by_threads(folder: Path) -> float:
    """Return how much faster two threads are than one, on runs of 10 ms and more."""
    simulations = [_prepare(ring.system(folder, 2), 1_000_000, "jacobi") for _ in range(2)]

    def work(simulation) -> None:
        for _ in range(5):
            simulation.run()

    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(2) as two:
        seconds = interleaved(
            {
                "one": lambda: list(one.map(work, simulations)),
                "two": lambda: list(two.map(work, simulations)),
            },
            11,
        )
    return seconds["one"] / seconds["two"]


def _per_step(system, steps: int, coupling: str, record=("mass.v",)) -> float:
    once, twice = (_prepare(system, n, coupling, record) for n in (steps, 2 * steps))
    seconds = interleaved({"once": once.run, "twice": twice.run}, 15, time.thread_time)
    return (seconds["twice"] - seconds["once"]) / steps * 1e9


def _prepare(system, steps: int, coupling: str, record=("mass.v",)):
    stop = steps * ring.STEP
    return system.prepare(step=ring.STEP, stop=stop, coupling=coupling, record=record)
