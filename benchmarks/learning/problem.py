"""The problem of the races: five LuGre genes and the cost of the paper's closed loop of FMUs."""

import statistics
import time
from pathlib import Path

import numpy as np

from benchmarks import measurements
from benchmarks.common import design
from stickslip import cosim, ga
from stickslip.catalog.parameters import LUGRE, PAPER, UNITS
from stickslip.cosim import SineSweep
from stickslip.servo.axis import LOOP
from stickslip.servo.systems import build_fmus, paper_loop
from stickslip.tuning.learning import VelocityCost

COARSENESS = dict(zip(LUGRE, (0.3, 0.1, 0.8, 0.3, 0.5), strict=True))
"""Standard deviation of what was identified, as a logarithm."""
KINDS = {
    "measured": {},  # encoder steps make the cost rough
    "smooth": {"encoder": False, "dac": False},
}


def cost(folder: Path, kind: str = "measured", duration: float = 2.5) -> ga.SimulatedCost:
    """Return the cost function of a candidate on the drive, over a sweep of a duration [s]."""
    build_fmus(folder, KINDS[kind])
    system, record = paper_loop(folder, design(), {}), ("drive.x_enc", "nominal.v_r")
    specification = cosim.Specification(system, LOOP.T_s, duration, record=record)
    sweep = SineSweep(frequency=(0.1, 5.0), amplitude=(0.030, 0.040), duration=duration)
    command = sweep.sample(np.arange(round(duration / LOOP.T_s) + 1) * LOOP.T_s)
    names = [f"compensator.{name}" for name in LUGRE]
    return ga.SimulatedCost(specification, names, VelocityCost(LOOP.T_s), {"v_cmd": command})


def problem(seed: int) -> ga.Problem:
    """Return genes around a coarse identification that differs from seed to seed."""
    rng = np.random.default_rng(1000 + seed)
    errors = {name: spread * rng.standard_normal() for name, spread in COARSENESS.items()}
    start = {name: PAPER[name] * float(np.exp(error)) for name, error in errors.items()}
    start["F_s"] = max(start["F_s"], start["F_c"])
    genes = [ga.Gene(n, 0.1 * value, 100 * value, value, UNITS[n]) for n, value in start.items()]
    return ga.Problem(genes, ga.AtLeast("F_s", "F_c"))


GOALS = {"threads": 1.9, "processes": 1.9, "Dask": 1.7}
PLACES = {"threads": "threads", "processes": "processes", "Dask": "local"}
EVALUATIONS, ROUNDS = 500, 7


def scaling(folder: Path) -> dict[str, float]:
    """Learning on two workers, relative to one: threads, processes and Dask; all learn the same."""
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
