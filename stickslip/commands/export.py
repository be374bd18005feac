"""``stickslip export``: what was learned or designed, for other tools."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import models
from models.firmware import write_compensator
from stickslip.commands import export_system
from stickslip.errors import UsageError
from stickslip.learned import read_learned


def add_to(subparsers: argparse._SubParsersAction[Any]) -> None:
    """Declare the command and what it exports."""
    parser = subparsers.add_parser("export", help="export the tuned compensator or a whole loop")
    exports = parser.add_subparsers(dest="what", metavar="compensator|FILE.ssp", required=True)
    exports.choices = exports._name_parser_map = _Parsers()  # noqa: SLF001 - no public way
    _add_compensator(exports)
    export_system.add_to(exports)


class _Parsers(dict[str, argparse.ArgumentParser]):
    """Parsers by what they export: a file stands for the one of its kind."""

    def __contains__(self, name: object) -> bool:
        is_file = str(name).endswith(".ssp") and name != export_system.NAME
        return super().__contains__(name) or is_file

    def __missing__(self, name: str) -> argparse.ArgumentParser:
        return self[export_system.NAME]


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


def _version(options: argparse.Namespace) -> models.FmiVersion:
    return 2 if options.fmi == "2" else 3
