"""A candidate of 10 s at 2 kHz: against the same physics as plain C, and FMPy's simulate_fmu."""

from __future__ import annotations

import time
from pathlib import Path

import fmpy
import numpy as np

from benchmarks.learning.fused import FusedLoop
from benchmarks.learning.problem import cost, problem
from stickslip import cosim, ga
from stickslip.catalog.parameters import LUGRE, PAPER

DURATION = 10.0


def measure(folder: Path, evaluations: int = 100) -> dict[str, float]:
    """Return ratios; learning and C take turns, and count the processor's seconds."""
    with cost(folder, duration=DURATION) as evaluate:
        specification, command = evaluate.specification, evaluate.inputs["v_cmd"]
        fused = FusedLoop(specification.system, specification.step, command)
        _check(evaluate, fused, command)
        rounds = max(1, evaluations // 100)
        ratios, ours, kernels = [], [], []
        for seed in range(rounds):
            limits = ga.Limits(evaluations=102)
            optimiser = ga.optimiser("default", problem(seed), limits, seed)
            seconds, _ = _timed(lambda o=optimiser: ga.learn(o, evaluate))
            tried = optimiser.history[list(LUGRE)].to_numpy()
            plain, _ = _timed(lambda t=tried: _run_all(fused, t))
            kernel, _ = _timed(lambda t=tried: [_simulate(evaluate, row) for row in t])
            ratios.append(seconds / plain)
            kernels.append(kernel / plain)
            ours.append(seconds / len(tried))
        sealed = cosim.write_fmu(specification.system, folder / "loop.fmu", step=specification.step)
        theirs = _fmpy(sealed, command, specification.step)
    return {
        "ms per evaluation, learning": 1e3 * float(np.median(ours)),
        "learning / fused C loop of the same candidates": float(np.median(ratios)),
        "runs of FMUs alone / fused C loop": float(np.median(kernels)),
        "FMPy's simulate_fmu of the loop in one FMU / learning": theirs / float(np.median(ours)),
    }


def _check(evaluate: ga.SimulatedCost, fused: FusedLoop, command: np.ndarray) -> None:
    values = {f"compensator.{name}": PAPER[name] for name in LUGRE}
    with evaluate.specification.prepare() as simulation:
        result = simulation.run(values, {"v_cmd": command})
    fused.set(values)
    fused.run()
    if not np.array_equal(result["drive.x_enc"], fused.x_enc):
        raise RuntimeError("the fused loop is not the loop of FMUs")


def _run_all(fused: FusedLoop, candidates: np.ndarray) -> None:
    for values in candidates:
        fused.set({f"compensator.{n}": v for n, v in zip(LUGRE, values, strict=True)})
        fused.run()


def _simulate(evaluate: ga.SimulatedCost, values: np.ndarray) -> None:
    parameters = dict(zip(evaluate.names, values.tolist(), strict=True))
    evaluate._simulation().run(parameters, evaluate.inputs)  # noqa: SLF001 - as `evaluate` does


def _fmpy(path: Path, command: np.ndarray, step: float) -> float:
    """Return the seconds of one run of the system in one FMU, read and unpacked before."""
    description = fmpy.read_model_description(path)
    folder = fmpy.extract(path)
    time_points = np.arange(len(command)) * step
    table = np.array(
        list(zip(time_points, command, strict=True)), dtype=[("time", float), ("v_cmd", float)]
    )

    def simulate() -> object:
        return fmpy.simulate_fmu(
            folder,
            model_description=description,
            stop_time=time_points[-1],
            step_size=step,
            output_interval=step,
            input=table,
            output=["drive.x_enc", "nominal.v_r"],
        )

    simulate()
    return min(_timed(simulate)[0] for _ in range(3))


def _timed(run) -> tuple[float, object]:
    begin = time.process_time()
    result = run()
    return time.process_time() - begin, result
