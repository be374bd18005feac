"""``stickslip export lti``: a state space or transfer function as an FMU."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from stickslip.commandline import FLAG, add_options
from stickslip.commandline.platforms import add_fmu_options, fmu_options
from stickslip.output import Answer


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser("lti", help="a state space or transfer function as an FMU")
    parser.add_argument(
        "file", type=Path, metavar="FILE.toml|FILE.json", help="see models/lti/README.md"
    )
    times = dict.fromkeys(("--step S", "--stop S"), "proposed by the FMU (default: from the poles)")
    add_options(parser, times, type=float)
    held = "outputs with direct gain hold the last sample, for controllers in discrete time"
    add_options(parser, {"--held": held}, **FLAG)
    add_fmu_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Write DIR/NAME.fmu and print its path."""
    from stickslip import models

    described = models.read_lti(options.file)
    path = models.export_lti(
        described.system,
        options.out,
        step=described.step if options.step is None else options.step,
        stop=described.stop if options.stop is None else options.stop,
        held=options.held,
        **fmu_options(options),
    )
    print(path)
    return Answer({"written": [path]})
