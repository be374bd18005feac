"""Learning on two workers, relative to one: threads, processes and Dask."""

from __future__ import annotations

import statistics
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.learning import figures
from benchmarks.learning.problem import cost, problem
from stickslip import ga

GOALS = {"threads": 1.9, "processes": 1.9, "Dask": 1.7}
PLACES = {"threads": "threads", "processes": "processes", "Dask": "local"}
EVALUATIONS, ROUNDS = 500, 7


def run(folder: Path, out: Path) -> dict[str, float]:
    """Measure, write workers.csv and a figure, and return the speeds; all must learn the same."""
    speeds: dict[str, float] = {}
    with cost(folder, duration=10.0) as judge:
        for name, where in PLACES.items():
            with ga.executor(where, 1) as one, ga.executor(where, 2) as two:
                for executor in (one, two):  # prepares a simulation in each worker
                    _learn(judge, executor, 30)
                rounds = [
                    [_learn(judge, executor, EVALUATIONS) for executor in (one, two)]
                    for _ in range(ROUNDS)
                ]
            if len({history for pair in rounds for _, history in pair}) > 1:
                raise RuntimeError(f"{name}: one and two workers learned differently")
            speeds[name] = statistics.median(a / b for (a, _), (b, _) in rounds)
        limit = _limit(judge)
    lines = [f"{name},{speed:.3f},{GOALS[name]}" for name, speed in speeds.items()]
    (out / "workers.csv").write_text("\n".join(["workers,two / one,goal", *lines, ""]))
    figures.workers(out / "workers.png", speeds, GOALS)
    found = {f"two {name} / one": speed for name, speed in speeds.items()}
    return found | {"candidates without learning, two threads / one: what the machine has": limit}


def _limit(judge: ga.SimulatedCost) -> float:
    """Return how much faster two threads run candidates than one when nothing depends on them."""
    candidates = [problem(0).start] * (EVALUATIONS // 5)
    ratios = []
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(2) as two:
        for _ in range(ROUNDS):
            seconds = []
            for threads in (one, two):
                begin = time.perf_counter()
                list(threads.map(judge, candidates))
                seconds.append(time.perf_counter() - begin)
            ratios.append(seconds[0] / seconds[1])
    return statistics.median(ratios)


def _learn(judge: ga.SimulatedCost, executor, evaluations: int) -> tuple[float, str]:
    optimiser = ga.optimiser("default", problem(0), ga.Limits(evaluations=evaluations))
    begin = time.perf_counter()
    ga.learn(optimiser, judge, executor)
    return time.perf_counter() - begin, optimiser.history.to_csv()
