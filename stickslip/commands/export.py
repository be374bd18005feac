"""``stickslip export``: the tuned compensator, an observer or a drive.

stickslip export compensator --parameters axis/learned.json --as c --out firmware
stickslip export drive --of emps --out robot
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from stickslip.commandline import add_options, complete_with, warn, written
from stickslip.commands.export_compensator import add_compensators
from stickslip.output import Answer


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare what the command exports."""
    exports = parser.add_subparsers(
        dest="what",
        metavar="compensator|observer|position_force|deploy|drive|rig",
        required=True,
    )
    for add in (add_compensators, add_drive, add_rig):
        add(exports)


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


def add_rig(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser("rig", help="what runs motions in a Beckhoff controller: PLC code")
    parser.description = (
        "Write the function block StickslipRig in structured text. A Beckhoff controller that "
        "calls it runs the motions that ss.AdsRig asks for; docs/rig.md says how."
    )
    out = {"--out DIR": "folder to write into (default .)"}
    add_options(parser, out, type=Path, default=Path())
    parser.set_defaults(run=export_rig)


def export_rig(options: argparse.Namespace) -> Answer:
    """Write the function block and print its path."""
    from stickslip.fmi.files import atomic_write  # late: loads more than the command line needs
    from stickslip.rigs.ads_rig import CODE

    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / CODE.name
    atomic_write(path, CODE.read_text(encoding="utf-8"))
    return written(path)
