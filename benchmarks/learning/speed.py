"""A candidate of 10 s at 2 kHz: learning against the runs alone, and FMPy's simulate_fmu."""

import time
from pathlib import Path

import fmpy
import numpy as np

from benchmarks.learning.problem import cost, problem
from stickslip import cosim, ga
from stickslip.catalog.parameters import LUGRE

DURATION = 10.0


def measure(folder: Path, evaluations: int = 100) -> dict[str, float]:
    """Return ratios; learning and its runs take turns, and count the processor's seconds."""
    with cost(folder, duration=DURATION) as evaluate:
        specification, command = evaluate.specification, evaluate.inputs["v_cmd"]
        ratios, ours = [], []
        for seed in range(max(1, evaluations // 100)):
            optimiser = ga.optimiser("default", problem(seed), ga.Limits(evaluations=102), seed)
            seconds, _ = _timed(lambda o=optimiser: ga.learn(o, evaluate))
            tried = optimiser.history[list(LUGRE)].to_numpy()
            alone, _ = _timed(lambda t=tried: [evaluate.result(row) for row in t])
            ratios.append(seconds / alone)
            ours.append(seconds / len(tried))
        sealed = cosim.write_fmu(specification.system, folder / "loop.fmu", step=specification.step)
        theirs = _fmpy(sealed, command, specification.step)
    return {
        "ms per evaluation, learning": 1e3 * float(np.median(ours)),
        "learning / runs of the same candidates": float(np.median(ratios)),
        "FMPy's simulate_fmu of the loop in one FMU / learning": theirs / float(np.median(ours)),
    }


def _fmpy(path: Path, command: np.ndarray, step: float) -> float:
    """Return the seconds of one run of the system in one FMU, read and unpacked before."""
    description = fmpy.read_model_description(path)
    folder = fmpy.extract(path)
    time_points = np.arange(len(command)) * step
    kinds = [("time", float), ("v_cmd", float)]
    table = np.array(list(zip(time_points, command, strict=True)), dtype=kinds)

    def simulate() -> object:
        times = {"stop_time": time_points[-1], "step_size": step, "output_interval": step}
        signals = {"input": table, "output": ["drive.x_enc", "nominal.v_r"]}
        return fmpy.simulate_fmu(folder, model_description=description, **times, **signals)

    simulate()
    return min(_timed(simulate)[0] for _ in range(3))


def _timed(run) -> tuple[float, object]:
    begin = time.process_time()
    result = run()
    return time.process_time() - begin, result
