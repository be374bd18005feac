"""``stickslip identify``: identify the parameters of the drive FMU.

stickslip identify --out identified
"""

import argparse
import json
from pathlib import Path

from stickslip.catalog.parameters import UNITS
from stickslip.commandline import write_files
from stickslip.commandline.assignments import add_set_option, drive_changes
from stickslip.commandline.progress import TerminalProgress
from stickslip.output import Answer
from stickslip.storage import reserved


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for identified.json")
    add_set_option(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Run the experiments, print the estimates with standard errors, and write them."""
    from stickslip.identification.stages import identify
    from stickslip.papers.lugre.reproduction import drive_truth
    from stickslip.rigs.fmu import rig_of
    from stickslip.servo.axis import LOOP

    truth = drive_changes(options.set)
    drive_truth(truth)
    with reserved(options.out, ["identified.json"]):
        with rig_of(truth) as rig, TerminalProgress() as progress:
            estimates = identify(rig, LOOP, progress.stage).estimates
        content = {}
        for name, found in estimates.items():
            value, error, unit = found.value, found.standard_error, UNITS[name]
            print(f"{name:8} {value:12.6g} +- {error:<10.2g} {unit}")
            content[name] = {"value": value, "unit": unit, "standard_error": error}
        changed = {f"drive.{name}": value for name, value in truth.items()}
        files = {"identified.json": json.dumps(content, indent=2) + "\n"}
        write_files(options.out, {"name": "identify", "set": changed}, files)
        return Answer(content)
