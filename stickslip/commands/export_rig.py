"""``stickslip export rig``: the function block that runs the motions of ``ss.AdsRig``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from stickslip.commandline import add_options
from stickslip.output import Answer


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser("rig", help="what runs motions in a Beckhoff controller: PLC code")
    parser.description = (
        "Write the function block StickslipRig in structured text. A Beckhoff controller that "
        "calls it runs the motions that ss.AdsRig asks for; docs/rig.md says how."
    )
    out = {"--out DIR": "folder to write into (default .)"}
    add_options(parser, out, type=Path, default=Path())
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Write the function block and print its path."""
    from stickslip.fmi.files import atomic_write  # late: loads more than the command line needs
    from stickslip.rigs.ads_rig import CODE

    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / CODE.name
    atomic_write(path, CODE.read_text(encoding="utf-8"))
    print(path)
    return Answer({"written": [path]})
