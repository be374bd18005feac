"""``stickslip export``: what was learned or designed, for other tools."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import models
from models.firmware import write_compensator
from stickslip.errors import UsageError
from stickslip.learned import read_learned


def add_to(subparsers: argparse._SubParsersAction[Any]) -> None:
    """Declare the command and what it exports."""
    parser = subparsers.add_parser(
        "export", help="the tuned compensator, or a linear system, for other tools"
    )
    exports = parser.add_subparsers(metavar="WHAT", required=True)
    _add_compensator(exports)
    _add_lti(exports)


def _add_compensator(exports: argparse._SubParsersAction[Any]) -> None:
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
    _add_fmu_options(parser)
    parser.set_defaults(run=_export_compensator)


def _add_lti(exports: argparse._SubParsersAction[Any]) -> None:
    parser = exports.add_parser("lti", help="a state space or transfer function as an FMU")
    parser.add_argument(
        "file", type=Path, metavar="FILE.toml|FILE.json", help="see models/lti/README.md"
    )
    parser.add_argument("--step", type=float, metavar="S", help="that the FMU proposes")
    parser.add_argument("--stop", type=float, metavar="S", help="that the FMU proposes")
    parser.add_argument(
        "--held",
        action="store_true",
        help="outputs with direct gain hold the last sample, for controllers in discrete time",
    )
    _add_fmu_options(parser)
    parser.set_defaults(run=_export_lti)


def _add_fmu_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--fmi", choices=["2", "3"], default="2", help="version of the standard")
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR")


def _export_compensator(options: argparse.Namespace) -> None:
    """Write the compensator with its learned start values and print the paths."""
    start = read_learned(options.parameters)
    try:
        if options.form == "fmu":
            paths = [
                models.build_fmu("compensator", options.out, fmi=_version(options), start=start)
            ]
        else:
            paths = write_compensator(options.out, options.form, start=start)
    except models.StartValueError as error:
        raise UsageError(f"{options.parameters}: {error}") from None
    print(*paths, sep="\n")


def _export_lti(options: argparse.Namespace) -> None:
    """Write the system as an FMU and print its path."""
    described = models.read_lti(options.file)
    print(
        models.export_lti(
            described.system,
            options.out,
            step=described.step if options.step is None else options.step,
            stop=described.stop if options.stop is None else options.stop,
            held=options.held,
            fmi=_version(options),
        )
    )


def _version(options: argparse.Namespace) -> models.FmiVersion:
    return 2 if options.fmi == "2" else 3
