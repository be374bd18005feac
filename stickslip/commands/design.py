"""``stickslip design``: design the velocity loop from bandwidth and phase margin.

stickslip design --mass 8 --viscous 20
stickslip design --bandwidth 30 --phase-margin 60 --out loop
"""

import argparse
import json
from pathlib import Path

from stickslip.catalog.parameters import PAPER
from stickslip.commandline import write_files
from stickslip.output import Answer
from stickslip.servo.axis import LOOP, Datasheet, LoopSpecification


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    defaults = {
        "--bandwidth": (LOOP.bandwidth, "HZ", "gain crossover"),
        "--phase-margin": (LOOP.phase_margin, "DEG", "at the crossover"),
        "--sample-period": (LOOP.T_s, "S", "of the controller"),
        "--filter": (LOOP.tau_f, "S", "time constant of the velocity estimate's low-pass"),
        "--current-lag": (Datasheet().tau_i, "S", "time constant of the current loop"),
        "--mass": (PAPER["m"], "KG", "moving mass"),
        "--viscous": (PAPER["b"], "N.S/M", "viscous friction"),
    }
    for option, (value, unit, text) in defaults.items():
        parser.add_argument(
            option, type=float, default=value, metavar=unit, help=f"{text} (default {value:g})"
        )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for design.json")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Design, print gains and margins, and write them with the nominal loop's matrices."""
    from stickslip.servo.axis import Axis
    from stickslip.servo.systems import nominal_parameters
    from stickslip.servo.velocity_loop import design_velocity_loop

    loop = design_velocity_loop(
        Axis(options.mass, options.viscous, options.current_lag),
        LoopSpecification(
            options.bandwidth, options.phase_margin, options.sample_period, options.filter
        ),
    )
    figures = {"K_p": loop.K_p, "K_i": loop.K_i, **loop.margins()}
    for name, value in figures.items():
        print(f"{name:20} {value:.6g}")
    content = {**figures, "nominal_loop": nominal_parameters(loop)}
    files = {"design.json": json.dumps(content, indent=2) + "\n"}
    write_files(options.out, {"name": "design"}, files)
    return Answer(content)
