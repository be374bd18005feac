"""``stickslip export compensator``: the tuned compensator as FMU, C or structured text."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import models
from models.firmware import write_compensator
from stickslip.commands.platforms import add_platform_option, parse_platforms
from stickslip.errors import UsageError
from stickslip.learned import read_learned


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser("compensator", help="the tuned compensator: FMU, C or PLC code")
    parser.add_argument(
        "--parameters", type=Path, required=True, metavar="FILE.json", help="a learned.json"
    )
    parser.add_argument(
        "--as",
        dest="form",
        choices=["fmu", "c", "st"],
        default="fmu",
        help="an FMU (default), C99 for firmware, or IEC 61131-3 structured text for a PLC",
    )
    parser.add_argument("--fmi", choices=["2", "3"], default="2", help="version of the standard")
    add_platform_option(parser)
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Write the compensator with its learned start values and print the paths."""
    start = read_learned(options.parameters)
    try:
        paths = _write(options, start)
    except models.StartValueError as error:
        raise UsageError(f"{options.parameters}: {error}") from None
    print(*paths, sep="\n")


def _write(options: argparse.Namespace, start: dict[str, float]) -> list[Path]:
    if options.form != "fmu":
        return write_compensator(options.out, options.form, start=start)
    fmu = models.build_fmu(
        "compensator",
        options.out,
        fmi=2 if options.fmi == "2" else 3,
        platforms=parse_platforms(options.platform),
        start=start,
    )
    return [fmu]
