"""The problem of ``speed``: five LuGre genes and the cost of the paper's closed loop of FMUs."""

from pathlib import Path

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
