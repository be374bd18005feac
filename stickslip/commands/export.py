"""``stickslip export``: the tuned compensator, an observer, a drive or a loop.

stickslip export compensator --parameters axis/learned.json --as c --out firmware
stickslip export drive --of emps --out robot
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from stickslip.commandline import add_options, complete_with, warn, written
from stickslip.commandline.assignments import add_set_option, split_assignments
from stickslip.commandline.platforms import add_fmu_options, fmu_options
from stickslip.commands.export_compensator import add_compensators
from stickslip.errors import UsageError
from stickslip.output import Answer


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare what the command exports."""
    exports = parser.add_subparsers(
        dest="what",
        metavar="compensator|observer|position_force|deploy|drive|FILE.ssp",
        required=True,
    )
    exports.choices = exports._name_parser_map = _Parsers()  # noqa: SLF001 - no public way
    for add in (add_compensators, add_drive, add_system):
        add(exports)


class _Parsers(dict[str, argparse.ArgumentParser]):
    """Parsers by what they export: a file stands for the one of its kind."""

    def __contains__(self, name: object) -> bool:
        is_file = str(name).endswith((".ssp", ".fmu")) and name != SYSTEM
        return super().__contains__(name) or is_file

    def __missing__(self, name: str) -> argparse.ArgumentParser:
        return self[SYSTEM]


def add_drive(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser("drive", help="the drive for MuJoCo (MJCF) or as URDF")
    drives = parser.add_mutually_exclusive_group(required=True)
    add_options(drives, {"--parameters FILE.json": "a learned.json"}, type=Path)
    of = drives.add_argument("--of", metavar="NAME", help="a published drive, see docs/drives.md")
    complete_with(of, drive_names)
    parser.add_argument("--as", dest="form", choices=["mjcf", "urdf"], default="mjcf")
    out = {"--out DIR": "folder to write into (default .)"}
    add_options(parser, out, type=Path, default=Path())
    parser.set_defaults(run=export_drive)


def drive_names() -> list[str]:
    """Return the names of the published drives."""
    from stickslip.drives.published import drive_names  # late: loads what runs systems

    return drive_names()


def export_drive(options: argparse.Namespace) -> Answer:
    """Write DIR/drive.xml or .urdf, print its path, and warn of what the format leaves out."""
    from stickslip.drives import published, robots

    learned, of = options.parameters, options.of
    drive = published.drive(of) if of else published.Drive.learned(learned)
    path = robots.export_drive(drive, options.out, options.form)
    for sentence in robots.robot_model(drive, options.form).lost:
        warn(f"{path}: {sentence}")
    return written(path)


SYSTEM = "FILE.ssp"


def add_system(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser(SYSTEM, help="a whole system of FMUs as one FMU")
    parser.add_argument("--as", dest="form", choices=["fmu"], default="fmu")
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
    # For Windows its code needs a C runtime, which takes a minute to compile once.
    add_fmu_options(parser, platform="host", out="DIR|FILE.fmu")
    parser.set_defaults(run=export_system)


def export_system(options: argparse.Namespace) -> Answer:
    """Write DIR/NAME.fmu, named like the package, or FILE.fmu, and print its path."""
    from stickslip import cosim

    file = Path(options.what)
    if file.suffix == ".fmu":
        raise UsageError(f"{file}: an FMU already; this writes a system, FILE.ssp, as one")
    system, experiment = cosim.read_ssp(file, options.variant)
    step = experiment.step if options.step is None else options.step
    if step is None:
        raise UsageError(f"{file}: the file proposes no step; give --step")
    for name, value in split_assignments(options.set).items():
        system.set(name, value)
    path = cosim.write_fmu(
        system,
        options.out if options.out.suffix == ".fmu" else options.out / f"{file.stem}.fmu",
        step=step,
        coupling=options.coupling,
        outputs=options.outputs,
        parameters=options.parameters,
        experiment=replace(experiment, step=step),
        **fmu_options(options),
    )
    return written(path)
