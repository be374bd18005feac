"""A candidate of 10 s at 2 kHz: learning against the runs alone, and FMPy's simulate_fmu."""

import time
from pathlib import Path

import fmpy
import numpy as np

from benchmarks.common import design
from stickslip import cosim, ga
from stickslip.catalog.parameters import LUGRE, PAPER, UNITS
from stickslip.cosim import SineSweep
from stickslip.servo.axis import LOOP
from stickslip.servo.systems import build_fmus, paper_loop
from stickslip.tuning.learning import VelocityCost

COARSENESS = dict(zip(LUGRE, (0.3, 0.1, 0.8, 0.3, 0.5), strict=True))
"""Standard deviation of what was identified, as a logarithm."""


def cost(folder: Path, duration: float) -> ga.SimulatedCost:
    """Return the cost function of a candidate on the drive, over a sweep of a duration [s]."""
    build_fmus(folder, {})
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
