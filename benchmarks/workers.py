"""Forty candidates on two threads, relative to one."""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.loop import COMPENSATOR, INPUTS, specification
from stickslip.ga import SimulatedCost

CANDIDATES = 40


def measure(folder: Path) -> dict[str, float]:
    names = [f"compensator.{name}" for name in COMPENSATOR]
    values = np.array(list(COMPENSATOR.values()))
    speed = {}
    with SimulatedCost(specification(folder), names, _cost, INPUTS) as cost:
        for workers in (1, 2):
            with ThreadPoolExecutor(workers) as pool:
                list(pool.map(cost, [values] * workers))  # prepares a simulation in each
                begin = time.perf_counter()
                list(pool.map(cost, [values] * CANDIDATES))
                speed[workers] = CANDIDATES / (time.perf_counter() - begin)
    return {"candidates without learning, two threads / one": speed[2] / speed[1]}


def _cost(result) -> float:
    return float(np.sum(result["drive.x_enc"] ** 2))
