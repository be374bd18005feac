"""``stickslip export lti``: a state space or transfer function as an FMU."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from stickslip import models
from stickslip.commands.platforms import add_platform_option, parse_platforms


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser("lti", help="a state space or transfer function as an FMU")
    parser.add_argument(
        "file", type=Path, metavar="FILE.toml|FILE.json", help="see models/lti/README.md"
    )
    for option in ("--step", "--stop"):
        parser.add_argument(
            option, type=float, metavar="S", help="proposed by the FMU (default: from the poles)"
        )
    parser.add_argument(
        "--held",
        action="store_true",
        help="outputs with direct gain hold the last sample, for controllers in discrete time",
    )
    parser.add_argument("--fmi", choices=["2", "3"], default="2", help="version of the standard")
    add_platform_option(parser)
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Write DIR/NAME.fmu and print its path."""
    described = models.read_lti(options.file)
    path = models.export_lti(
        described.system,
        options.out,
        step=described.step if options.step is None else options.step,
        stop=described.stop if options.stop is None else options.stop,
        held=options.held,
        fmi=2 if options.fmi == "2" else 3,
        platforms=parse_platforms(options.platform),
    )
    print(path)
