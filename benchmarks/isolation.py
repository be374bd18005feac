"""Runs of 10,000 steps with the FMUs in a process of their own, against runs in this one."""

import time
from dataclasses import replace
from pathlib import Path

from benchmarks.common import INPUTS, LOOP, interleaved, specification
from benchmarks.coupling import ring
from stickslip import cosim

STEPS, REPEATS = 10_000, 101  # of isolated runs


def measure(folder: Path) -> dict[str, float]:
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
