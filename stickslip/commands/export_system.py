"""``stickslip export FILE.ssp --as fmu``: a whole system as one FMU."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from stickslip.commandline import add_options
from stickslip.commandline.assignments import add_set_option, split_assignments
from stickslip.commandline.platforms import add_fmu_options, fmu_options
from stickslip.errors import UsageError
from stickslip.output import Answer

NAME = "FILE.ssp"


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser(NAME, help="a whole system of FMUs as one FMU")
    parser.add_argument("--as", dest="form", choices=["fmu"], required=True)
    step = {"--step S": "communication step, instead of that of the file"}
    add_options(parser, step, type=float)
    add_options(parser, {"--variant NAME": "variant of the .ssp to export, if it has several"})
    parser.add_argument(
        "--coupling",
        choices=["gauss_seidel", "jacobi"],
        default="gauss_seidel",
        help="(default gauss_seidel)",
    )
    add_set_option(parser, "start values: component.variable=VALUE")
    names = "names or patterns (drive.*) of the FMU's variables (default: "
    variables = {
        "--outputs NAME": f"{names}those of the system, or of all components)",
        "--parameters NAME": f"{names}all)",
    }
    add_options(parser, variables, nargs="*")
    add_fmu_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Write DIR/NAME.fmu, named like the package, and print its path."""
    from stickslip import cosim

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
        coupling=options.coupling,
        outputs=options.outputs,
        parameters=options.parameters,
        experiment=replace(experiment, step=step),
        **fmu_options(options),
    )
    print(path)
    return Answer({"written": [path]})
