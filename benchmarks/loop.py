"""The paper's loop, ready to run."""

from pathlib import Path

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.motions import TRAINING
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.systems import build_fmus, paper_loop
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop

STOP = 10.0
COMPENSATOR = {name: PAPER[name] for name in LUGRE}


def design() -> VelocityLoop:
    return design_velocity_loop(Datasheet().axis(PAPER["m"], PAPER["b"]), LOOP)


def specification(folder: Path) -> cosim.Specification:
    build_fmus(folder, {})
    system = paper_loop(folder, design(), COMPENSATOR)
    return cosim.Specification(system, LOOP.T_s, STOP, record=("drive.x_enc", "nominal.v_r"))


INPUTS = {"v_cmd": TRAINING}
