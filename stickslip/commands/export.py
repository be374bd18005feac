"""``stickslip export compensator``: the tuned compensator as an FMU."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import models
from stickslip.learned import read_learned


def add_to(subparsers: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = subparsers.add_parser("export", help="export the tuned compensator as an FMU")
    parser.add_argument("model", choices=["compensator"], metavar="compensator")
    parser.add_argument(
        "--parameters", type=Path, required=True, metavar="FILE.json", help="a learned.json"
    )
    parser.add_argument("--fmi", choices=["2", "3"], default="2")
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Build compensator.fmu with the learned start values and print its path."""
    start = read_learned(options.parameters)
    version: models.FmiVersion = 2 if options.fmi == "2" else 3
    print(models.build_fmu("compensator", options.out, fmi=version, start=start))
