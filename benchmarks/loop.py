"""The paper's loop, ready to run."""

from pathlib import Path

import cosim
from cosim.control import VelocityLoop, design_velocity_loop
from stickslip.loop import build_fmus, paper_loop
from stickslip.parameters import LUGRE, PAPER
from stickslip.setup import LOOP, TRAINING, Datasheet

STOP = 10.0
COMPENSATOR = {name: PAPER[name] for name in LUGRE}


def design() -> VelocityLoop:
    return design_velocity_loop(Datasheet().axis(PAPER["m"], PAPER["b"]), LOOP)


def specification(folder: Path) -> cosim.Specification:
    build_fmus(folder, {})
    system = paper_loop(folder, design(), COMPENSATOR)
    return cosim.Specification(system, LOOP.T_s, STOP, record=("drive.x_enc", "nominal.v_r"))


INPUTS = {"v_cmd": TRAINING}
