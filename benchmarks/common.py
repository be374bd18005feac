"""The paper's loop, ready to run, and times that can be compared, with their table."""

import resource
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
    choose: Callable[[list[float]], float] = statistics.median,
    *,
    warm: int = 0,
) -> dict[str, float]:
    """Return the median seconds of each case, or another choice; every repeat runs all cases once.

    Before each there are so many ``warm`` runs, so that all find in the cache what they write to.
    """
    times: dict[str, list[float]] = {name: [] for name in cases}
    for run in cases.values():
        run()
    for _ in range(repeats):
        for name, run in cases.items():
            for _ in range(warm):
                run()
            begin = clock()
            run()
            times[name].append(clock() - begin)
    return {name: choose(seconds) for name, seconds in times.items()}


def cpu() -> float:
    """Return the CPU seconds of this process and of those that it has waited for."""
    usages = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


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
