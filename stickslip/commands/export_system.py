"""``stickslip export FILE.ssp --as fmu``: a whole system as one FMU."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from stickslip import cosim
from stickslip.commands.assignments import add_set_option, split_assignments
from stickslip.commands.platforms import add_platform_option, parse_platforms
from stickslip.errors import UsageError

NAME = "FILE.ssp"


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser(NAME, help="a whole system of FMUs as one FMU")
    parser.add_argument("--as", dest="form", choices=["fmu"], required=True)
    parser.add_argument("--fmi", choices=["2", "3"], default="2", help="version of the standard")
    parser.add_argument(
        "--step", type=float, metavar="S", help="communication step, instead of that of the file"
    )
    parser.add_argument(
        "--variant", metavar="NAME", help="variant of the .ssp to export, if it has several"
    )
    parser.add_argument(
        "--coupling",
        choices=["gauss_seidel", "jacobi"],
        default="gauss_seidel",
        help="(default gauss_seidel)",
    )
    add_set_option(parser, "start values: component.variable=VALUE")
    for what, usual in (
        ("outputs", "those of the system, or of all components"),
        ("parameters", "all"),
    ):
        parser.add_argument(
            f"--{what}",
            nargs="*",
            metavar="NAME",
            help=f"names or patterns (drive.*) of the FMU's variables (default: {usual})",
        )
    add_platform_option(parser)
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Write DIR/NAME.fmu, named like the package, and print its path."""
    file = Path(options.what)
    system, experiment = cosim.read_ssp(file, options.variant)
    step = experiment.step if options.step is None else options.step
    if step is None:
        raise UsageError(f"{file}: the file proposes no step; give --step")
    for name, value in split_assignments(options.set).items():
        system.set(name, value)
    path = cosim.write_fmu(
        system,
        options.out / f"{file.stem}.fmu",
        step=step,
        fmi=2 if options.fmi == "2" else 3,
        coupling=options.coupling,
        outputs=options.outputs,
        parameters=options.parameters,
        experiment=replace(experiment, step=step),
        platforms=parse_platforms(options.platform),
    )
    print(path)
