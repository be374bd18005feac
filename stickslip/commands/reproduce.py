"""``stickslip reproduce``: the paper from beginning to end."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from stickslip.commands.assignments import add_set_option, drive_changes
from stickslip.commands.execution import (
    add_algorithm_option,
    add_execution_options,
    execution_of,
    forget,
    keeping,
)
from stickslip.commands.learn import print_estimation
from stickslip.commands.progress import TerminalProgress
from stickslip.commands.table4 import print_table4
from stickslip.errors import UsageError
from stickslip.execution import Execution
from stickslip.loop import FEEDS
from stickslip.record_mode import reproduce_from_recording
from stickslip.record_results import FILES as RECORD_FILES
from stickslip.record_results import write_record_results
from stickslip.reproduction import Options, drive_truth, reproduce
from stickslip.result_folder import reserved
from stickslip.results import FILES, write_results
from stickslip.studies import with_studies
from stickslip.validation import Validation
from toolchain import temporary_folder


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--out", type=Path, default=Path("results/paper"), metavar="DIR")
    parser.add_argument(
        "--mode",
        choices=["drive", "record"],
        default="drive",
        help="drive: each candidate runs on the drive FMU, as in the paper; record: all is learned "
        "from one recording of 20 s",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the algorithm")
    add_algorithm_option(parser, "--preset")
    add_execution_options(parser)
    parser.add_argument(
        "--feed",
        choices=FEEDS,
        default="nominal",
        help="what drives the compensator: the nominal loop's velocity, or the command",
    )
    add_set_option(parser, "change the drive's truth: drive.NAME=VALUE")
    parser.set_defaults(run=run)


def _drive(
    options: Options, fmus: Path, progress: TerminalProgress, execution: Execution, out: Path
) -> Validation:
    reproduction = reproduce(options, fmus, progress, execution)
    reproduction = with_studies(reproduction, fmus, progress, execution)
    progress.stage("writing the report")
    write_results(reproduction, out)
    return reproduction.validation


def _record(
    options: Options, fmus: Path, progress: TerminalProgress, execution: Execution, out: Path
) -> Validation:
    reproduction = reproduce_from_recording(options, fmus, progress, execution)
    print_estimation(reproduction.estimation)
    print()
    progress.stage("writing the report")
    write_record_results(reproduction, out)
    return reproduction.validation


MODES = {"drive": (_drive, FILES), "record": (_record, RECORD_FILES)}
"""By name: what computes and writes, and the names of the files."""


def run(options: argparse.Namespace) -> None:
    """Reproduce, write the results and print the main figures."""
    if options.seed < 0:
        raise UsageError(f"--seed must be at least 0, got {options.seed}")
    chosen = Options(
        truth=drive_changes(options.set),
        seed=options.seed,
        preset=options.algorithm,
        feed=options.feed,
    )
    drive_truth(chosen.truth)  # a wrong name or value is told before anything is done
    compute, files = MODES[options.mode]
    with (
        reserved(options.out, files),
        temporary_folder() as fmus,
        TerminalProgress(sys.stderr) as progress,
    ):
        execution = execution_of(options, options.out / "learning.checkpoint.json")
        with keeping(execution, options):
            validation = compute(chosen, fmus, progress, execution, options.out)
            forget(execution, options)
    print_table4(validation.table())
    print(f"all results in {options.out}; begin with report.html")
