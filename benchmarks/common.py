"""The paper's loop, ready to run, and times that can be compared, with their table."""

import statistics
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.motions import TRAINING
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.systems import build_fmus, paper_loop
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop


def interleaved(
    cases: Mapping[str, Callable[[], object]],
    repeats: int,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Return the median seconds of each case; every repeat runs all cases once."""
    times: dict[str, list[float]] = {name: [] for name in cases}
    for run in cases.values():
        run()
    for _ in range(repeats):
        for name, run in cases.items():
            begin = clock()
            run()
            times[name].append(clock() - begin)
    return {name: statistics.median(seconds) for name, seconds in times.items()}


def table(figures: Mapping[str, float]) -> str:
    """Return a line for each figure."""
    return "\n".join(f"  {name:76} {figure:8.4g}" for name, figure in figures.items())


STOP = 10.0
COMPENSATOR = {name: PAPER[name] for name in LUGRE}


def design() -> VelocityLoop:
    return design_velocity_loop(Datasheet().axis(PAPER["m"], PAPER["b"]), LOOP)


def specification(folder: Path) -> cosim.Specification:
    build_fmus(folder, {})
    system = paper_loop(folder, design(), COMPENSATOR)
    return cosim.Specification(system, LOOP.T_s, STOP, record=("drive.x_enc", "nominal.v_r"))


INPUTS = {"v_cmd": TRAINING}
