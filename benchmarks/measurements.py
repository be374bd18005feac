"""Small measurements, a function each."""

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.common import COMPENSATOR, INPUTS, LOOP, interleaved, specification
from benchmarks.coupling import ring
from stickslip import cosim
from stickslip.ga import SimulatedCost

CANDIDATES = 40
STEPS, REPEATS = 10_000, 101  # of isolated runs


def isolation(folder: Path) -> dict[str, float]:
    """Runs of 10,000 steps with the FMUs in a process of their own, against runs in this one."""
    paper = replace(specification(folder), stop=STEPS * LOOP.T_s)
    stop = STEPS * ring.STEP
    cases = {
        "paper's loop, what a cost needs": (paper, INPUTS),
        "paper's loop, all signals": (replace(paper, record=None), INPUTS),
        "ring of 3": (cosim.Specification(ring.system(folder, 2), ring.STEP, stop), {}),
        "ring of 3, FMI 3.0": (cosim.Specification(ring.system(folder, 3), ring.STEP, stop), {}),
        "ring of 9": (cosim.Specification(ring.system(folder, 2, 9), ring.STEP, stop), {}),
    }
    ratios = {}
    for name, (case, inputs) in cases.items():
        begin = time.perf_counter()
        there = replace(case, isolation="process").prepare()
        started = time.perf_counter() - begin
        with case.prepare() as here, there:
            seconds = interleaved(
                {
                    "here": lambda here=here, inputs=inputs: here.run(inputs=inputs),
                    "there": lambda there=there, inputs=inputs: there.run(inputs=inputs),
                },
                REPEATS,
            )
        ratios[f"{name}: isolated / here"] = seconds["there"] / seconds["here"]
        ratios[f"{name}: here (ms)"] = 1e3 * seconds["here"]
    ratios["start of a child (ms)"] = 1e3 * started
    return ratios


def workers(folder: Path) -> dict[str, float]:
    """Forty candidates on two threads, relative to one."""
    names = [f"compensator.{name}" for name in COMPENSATOR]
    values = np.array(list(COMPENSATOR.values()))
    speed = {}
    with SimulatedCost(specification(folder), names, _cost, INPUTS) as cost:
        for threads in (1, 2):
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(cost, [values] * threads))  # prepares a simulation in each
                begin = time.perf_counter()
                list(pool.map(cost, [values] * CANDIDATES))
                speed[threads] = CANDIDATES / (time.perf_counter() - begin)
    return {"candidates without learning, two threads / one": speed[2] / speed[1]}


def _cost(result) -> float:
    return float(np.sum(result["drive.x_enc"] ** 2))
