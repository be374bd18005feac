"""``stickslip export components``: compensators that learn, with what they learned."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from stickslip.commandline import add_options
from stickslip.commandline.platforms import add_fmu_options
from stickslip.commands.export_compensator import add_form_option, write_as
from stickslip.errors import UsageError
from stickslip.output import Answer


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser("components", help="compensators that learn: FMU, C or PLC code")
    parameters = {"--parameters FILE.json": "a learned.json or winner.json with components"}
    add_options(parser, parameters, type=Path, required=True)
    add_form_option(parser)
    add_fmu_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Write each component under its name and print the paths.

    Raises UsageError when there is none, or it is not available in the form that is wanted.
    """
    from stickslip.learned.file import LearnedFile

    learned = LearnedFile(options.parameters)
    components = learned.components
    if not components:
        raise UsageError(f"{options.parameters}: contains no components")
    written: list[Path] = []
    for name, model in components.items():
        given: dict[str, Any] = {
            "start": {v.name: v.start for v in model.variables if v.role == "parameter"},
            "law": model.law.name if model.law else None,
            "called": name,
            "rotary": learned.rotary,
        }
        paths = write_as(options, model.name, **given)
        print(*paths, sep="\n")
        written += paths
    return Answer({"written": written})
