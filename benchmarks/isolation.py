"""Runs of 10,000 steps with the FMUs in a process of their own, against runs in this one."""

import time
from dataclasses import replace
from pathlib import Path

from benchmarks import loop
from benchmarks.coupling import ring
from benchmarks.timing import interleaved
from stickslip import cosim

STEPS, REPEATS = 10_000, 101


def measure(folder: Path) -> dict[str, float]:
    paper = replace(loop.specification(folder), stop=STEPS * loop.LOOP.T_s)
    stop = STEPS * ring.STEP
    cases = {
        "paper's loop, what a cost needs": (paper, loop.INPUTS),
        "paper's loop, all signals": (replace(paper, record=None), loop.INPUTS),
        "ring of 3": (cosim.Specification(ring.system(folder, 2), ring.STEP, stop), {}),
        "ring of 3, FMI 3.0": (cosim.Specification(ring.system(folder, 3), ring.STEP, stop), {}),
        "ring of 9": (cosim.Specification(ring.system(folder, 2, 9), ring.STEP, stop), {}),
    }
    ratios = {}
    for name, (specification, inputs) in cases.items():
        begin = time.perf_counter()
        there = replace(specification, isolation="process").prepare()
        started = time.perf_counter() - begin
        with specification.prepare() as here, there:
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
