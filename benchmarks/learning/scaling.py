"""Learning on two workers, relative to one: threads, processes and Dask."""

import statistics
import time
from pathlib import Path

from benchmarks import measurements
from benchmarks.learning.problem import cost, problem
from stickslip import ga

GOALS = {"threads": 1.9, "processes": 1.9, "Dask": 1.7}
PLACES = {"threads": "threads", "processes": "processes", "Dask": "local"}
EVALUATIONS, ROUNDS = 500, 7


def run(folder: Path) -> dict[str, float]:
    """Return the speeds; one and two workers must learn the same."""
    speeds: dict[str, float] = {}
    with cost(folder, duration=10.0) as evaluate:
        for name, where in PLACES.items():
            with ga.executor(where, 1) as one, ga.executor(where, 2) as two:
                for executor in (one, two):  # prepares a simulation in each worker
                    _learn(evaluate, executor, 30)
                rounds = [
                    [_learn(evaluate, executor, EVALUATIONS) for executor in (one, two)]
                    for _ in range(ROUNDS)
                ]
            if len({history for pair in rounds for _, history in pair}) > 1:
                raise RuntimeError(f"{name}: one and two workers learned differently")
            speeds[name] = statistics.median(a / b for (a, _), (b, _) in rounds)
    found = {f"two {name} / one (goal {GOALS[name]})": speed for name, speed in speeds.items()}
    return found | measurements.workers(folder / "workers")


def _learn(evaluate: ga.SimulatedCost, executor, evaluations: int) -> tuple[float, str]:
    optimiser = ga.optimiser("default", problem(0), ga.Limits(evaluations=evaluations))
    begin = time.perf_counter()
    ga.learn(optimiser, evaluate, executor)
    return time.perf_counter() - begin, optimiser.history.to_csv()
