"""``stickslip info``: what an FMU or a system of FMUs contains.

stickslip info compensator.fmu
stickslip info loop.ssp --all
"""

import argparse
from pathlib import Path

from stickslip.commandline import FLAG, add_options
from stickslip.output import Answer


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Print interfaces, platforms, default experiment, inputs, outputs and parameters with units"
        " and start values; of a system also components and connections. Nothing is run."
    )
    parser.add_argument("file", type=Path, metavar="FILE.fmu|FILE.ssp")
    add_options(parser, {"--all": "also list the other variables"}, **FLAG)
    add_options(parser, {"--variant NAME": "variant of the .ssp to show, if it has several"})
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Print what the file contains."""
    from stickslip.contents import info

    found = info(options.file, options.variant)
    print(found.text(whole=options.all))
    return Answer(found.document())
