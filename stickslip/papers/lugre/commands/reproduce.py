"""``stickslip reproduce``: reproduce the paper: identify, learn, validate, report.

stickslip reproduce --out results/paper
stickslip reproduce --mode record --law dahl --out results/dahl
stickslip reproduce --mode log --out record
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.commandline import FLAG, add_options, at_least, warn
from stickslip.commandline.assignments import add_law_option, add_set_option, drive_changes
from stickslip.commandline.execution import (
    add_algorithm_option,
    add_seed_option,
    add_workers_option,
)
from stickslip.commandline.progress import TerminalProgress
from stickslip.errors import UsageError
from stickslip.fmi.process import temporary_folder
from stickslip.output import Answer
from stickslip.storage import reserved
from stickslip.studies.learn.command import print_estimation

if TYPE_CHECKING:
    from stickslip.papers.lugre.reproduction import Options, Reproduction


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    out = "folder of the results (default results/paper; with --as-published results/as_published)"
    add_options(parser, {"--out DIR": out}, type=Path)
    mode = (
        "drive: each candidate runs on the drive FMU, as in the paper; record: learn everything "
        "from one recording of 20 s; log: only write that recording, for learn"
    )
    add_options(parser, {"--mode": mode}, choices=["drive", "record", "log"], default="drive")
    published = (
        "only the paper's learning as published, from coarse starts over several seeds, beside the "
        "same with logarithmic genes and least squares"
    )
    add_options(parser, {"--as-published": published}, **FLAG)
    seeds = "number of seeds that learn the loop, as published and by least squares (default 5)"
    add_options(parser, {"--seeds N": seeds}, type=at_least(1), default=5, dest="number")
    add_algorithm_option(
        parser,
        default="CMA-ES for the loop, which needs half of the "
        "candidates of our genetic algorithm, and that for a recording",
    )
    add_workers_option(parser, "candidates")
    add_seed_option(parser)
    add_set_option(parser)
    add_law_option(parser)
    parser.set_defaults(run=run)


LEARNED = "learned.json"
Show = Callable[[], None]  # Prints what was computed


def _drive(
    options: Options, fmus: Path, progress: TerminalProgress, workers: int, out: Path
) -> Show:
    from stickslip.papers.lugre.folder import write_results
    from stickslip.papers.lugre.reproduction import reproduce

    reproduction = reproduce(options, fmus, progress, workers)
    progress.stage("writing the report")
    write_results(reproduction, out)
    return partial(_print_drive, reproduction)


def _print_drive(reproduction: Reproduction) -> None:
    from stickslip.papers.lugre import tables

    for warning in reproduction.identification.warnings:
        warn(warning)
    tables.print_table4(reproduction.table4())
    learned, loops = reproduction.refinement, reproduction.loops
    print(f"friction: {learned.result}; {learned.remark}")
    print("\nerror relative to tuned_pi, median [range] over friction and seeds")
    print(tables.stages(loops).text(), loops.sentence, sep="\n")


def _record(
    options: Options, fmus: Path, progress: TerminalProgress, workers: int, out: Path
) -> Show:
    from stickslip.papers.lugre.record import reproduce_from_recording, write_record_results
    from stickslip.papers.lugre.tables import print_table4

    reproduction = reproduce_from_recording(options, fmus, progress, workers)
    print_estimation(reproduction.learned.estimation)
    print()
    progress.stage("writing the report")
    write_record_results(reproduction, out)
    return partial(print_table4, reproduction.validation.table())


def _log(
    options: Options, fmus: Path, progress: TerminalProgress, _workers: int, out: Path
) -> Show:
    from stickslip.papers.lugre.record import write_log
    from stickslip.papers.lugre.reproduction import build_rig
    from stickslip.studies.learn.recorded import record_drive

    rig = build_rig(options, fmus, progress)
    progress.stage("recording the drive")
    write_log(record_drive(rig), options, out)
    return partial(print, f"{out / 'recording.csv'} is described by recording.toml beside it")


def _published(
    options: Options, fmus: Path, progress: TerminalProgress, workers: int, out: Path
) -> Show:
    from stickslip.identification.stages import identify
    from stickslip.papers.lugre.folder import write_published_results
    from stickslip.papers.lugre.published import PAPER_COST, study_as_published
    from stickslip.papers.lugre.reproduction import build_rig
    from stickslip.papers.lugre.tables import panel
    from stickslip.servo.axis import LOOP

    rig = build_rig(options, fmus, progress)
    found = identify(rig, LOOP, lambda name: progress.stage(f"identifying: {name}"))
    study = study_as_published(
        rig, found, options.all_seeds, workers=workers, on_stage=progress.stage
    )
    progress.stage("writing the report")
    write_published_results(study, options, out)
    return partial(
        print,
        "from coarse starts, median over seeds and encoder phases: cost in m2/s2, then the RMS\n"
        "error of the true velocity relative to that without compensation; there the cost is\n"
        f"{study.cost_without:.3g}, and {PAPER_COST:.2g} at the end on the real stage (paper)\n"
        f"{panel(study).text()}",
    )


def run(options: argparse.Namespace) -> Answer:
    """Reproduce, write the results and print the main figures."""
    _check(options)
    truth = drive_changes(options.set)
    from stickslip.papers.lugre.folder import FILES, PUBLISHED_FILES
    from stickslip.papers.lugre.record import LOG_FILES, RECORD_FILES
    from stickslip.papers.lugre.reproduction import Options, drive_truth

    chosen = Options(
        truth=truth,
        law=options.law,
        seed=options.seed,
        preset=options.algorithm,
        seeds=options.number,
    )
    drive_truth(chosen.truth, chosen.law)  # before anything is done
    compute, files = {
        "drive": (_drive, FILES),
        "record": (_record, RECORD_FILES),
        "log": (_log, LOG_FILES),
        "published": (_published, PUBLISHED_FILES),
    }["published" if options.as_published else options.mode]
    out = options.out or Path("results/as_published" if options.as_published else "results/paper")
    with reserved(out, files), temporary_folder() as fmus, TerminalProgress() as progress:
        show = compute(chosen, fmus, progress, options.workers, out)
    show()
    if "report.html" in files:
        print(f"all results are in {out}; open report.html first")
    learned = out / LEARNED
    found = json.loads(learned.read_text(encoding="utf-8")) if LEARNED in files else {}
    return Answer({"folder": out, **found})


def _check(options: argparse.Namespace) -> None:
    """Raise where an option means nothing to the learning as published."""
    others = {
        f"--mode {options.mode}": options.mode != "drive",
        f"--law {options.law}": options.law != "lugre",
        f"--algorithm {options.algorithm}": options.algorithm not in ("default", "paper"),
    }
    for other, given in others.items():
        if options.as_published and given:
            raise UsageError(
                f"--as-published and {other} exclude each other; leave one of them out"
            )
