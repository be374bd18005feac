"""``stickslip validate``: evaluate a compensator's parameters on the drive FMU, as in Table 4."""

from __future__ import annotations

import argparse
from pathlib import Path

from stickslip.commands import FLAG, add_options
from stickslip.commands.assignments import add_set_option, add_source_option, drive_changes
from stickslip.commands.progress import TerminalProgress
from stickslip.commands.tables import print_table4, write_files
from stickslip.evaluation.attribution import attribute
from stickslip.evaluation.validation import validate
from stickslip.identification.stages import identify
from stickslip.pipeline.reproduction import drive_truth
from stickslip.results.folder import reserved
from stickslip.results.learned import LearnedFile
from stickslip.servo.datasheet import LOOP, VALIDATION
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.rig import rig_of
from stickslip.servo.systems import FEEDS


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parameters = {"--parameters FILE.json": "parameters of the compensator: a learned.json"}
    add_options(parser, parameters, type=Path, required=True)
    add_source_option(parser, FEEDS)
    velocity_filter = (
        "compensate with a Kalman filter for the velocity and feedforward of inertia, and print "
        "the contribution of each"
    )
    add_options(parser, {"--velocity-filter": velocity_filter}, **FLAG)
    add_options(parser, {"--out DIR": "folder for table4.csv and attribution.csv"}, type=Path)
    add_set_option(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Identify the axis for its loop, run the trapezoid without and with the compensator."""
    truth = drive_changes(options.set)
    drive_truth(truth)
    learned = LearnedFile(options.parameters)
    compensator = learned.compensator
    with (
        reserved(options.out, ["table4.csv", "attribution.csv"]),
        rig_of(truth, learned.law.name) as rig,
        TerminalProgress() as progress,
    ):
        loop = plain = identify(rig, LOOP, progress.stage).loop
        if options.velocity_filter:
            loop = with_inertia(with_velocity_filter(plain, rig.datasheet, compensator["F_c"]))
        progress.stage("validating")
        validation = validate(rig, loop, compensator, VALIDATION, options.feed, plain)
        tables = {"table4.csv": validation.table()}
        print_table4(tables["table4.csv"])
        if options.velocity_filter:
            parts = attribute(rig, plain, compensator, VALIDATION, options.feed)
            tables["attribution.csv"] = parts
            print("Errors [mm/s] by what is on:", parts.round(3).to_string(index=False), sep="\n")
        command = {
            "name": "validate",
            "set": {f"drive.{name}": value for name, value in truth.items()},
            "parameters": compensator,
            "feed": options.feed,
        }
        files = {n: t.to_csv(index=False, lineterminator="\n") for n, t in tables.items()}
        write_files(options.out, command, files)
