"""``stickslip learn``: learn a drive from a log, and write the compensator that does best.

stickslip learn axis.csv --out axis
stickslip learn axis.csv --check
stickslip learn axis.csv --controller PI --gain K_p=4200 K_i=1.5e5 T_s=5e-4 --out axis
"""

from __future__ import annotations

import argparse
import math
import shutil
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip import commandline
from stickslip.catalog.parameters import unit_of
from stickslip.commandline.assignments import add_law_option
from stickslip.commandline.execution import (
    add_algorithm_option,
    add_seed_option,
    add_workers_option,
)
from stickslip.commandline.log_options import (
    add_log_argument,
    add_log_options,
    add_rig_option,
    description_of,
    logs_given,
    rig_of,
)
from stickslip.commandline.progress import TerminalProgress
from stickslip.compensators.names import part_names, require_parts
from stickslip.errors import RecordingError, UsageError
from stickslip.output import Answer
from stickslip.storage import reserved
from stickslip.thresholds import harm

if TYPE_CHECKING:
    from stickslip.identification.estimation import Estimation
    from stickslip.logs import Description, Finding
    from stickslip.studies.learn.folder import Written
    from stickslip.studies.learn.learned import LearnedFromRecording
    from stickslip.studies.learn.predicted_logs import PredictedLog

FIGURES = {
    "force": "force, inverse model",
    "force_unfiltered": "force, inverse model, recorded force unfiltered",
    "position": "position, simulated in closed loop",
    "velocity": "velocity, simulated in closed loop",
    "closed_loop_force": "force, simulated in closed loop",
}


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_log_argument(parser, several=True)
    commandline.add_options(parser, {"--out DIR": "folder for results and report"}, type=Path)
    held_out = {"--validate LOG": "logs whose force is predicted, but not learned from"}
    commandline.add_options(parser, held_out, type=Path, **commandline.SEVERAL)
    commandline.add_options(parser, {"--check": "only check the log"}, **commandline.FLAG)
    add_rig_option(parser, "instead of a log: the drive of this file runs one experiment")
    _declare_compensator(parser.add_argument_group("the compensator"))
    _declare_expected(parser.add_argument_group("what the drive will meet"))
    fixed = "the gains of the controller may not change: no others are tried"
    commandline.add_options(add_log_options(parser), {"--fixed-gains": fixed}, **commandline.FLAG)

    search = commandline.add_rare_group(parser, "the search")
    search.add_argument(
        "--criterion",
        choices=("auto", "inverse", "loop"),
        default="auto",
        help="loop: output error of the simulated closed loop; inverse: force predicted from the "
        "motion; auto: the one that the log allows",
    )
    add_seed_option(search)
    add_algorithm_option(search)
    add_workers_option(commandline.add_rare_group(parser, "where the search runs"), "candidates")
    parser.set_defaults(run=run)


def _declare_compensator(group: argparse._ArgumentGroup) -> None:
    add_law_option(
        group, "auto", more="; auto: the one that predicts the force best where it is not fitted"
    )
    named = group.add_argument(
        "--compensator",
        default="auto",
        metavar="NAME",
        help="what is written: a feedforward such as static or the name of the law, an observer "
        "such as ekbf or amin, both as in static+ekbf, or auto for the best of them on the drives "
        "that the log supports",
    )
    commandline.complete_with(named, lambda: ["auto", *part_names()])
    absent = {"--without SIGNAL": "signals that the controller cannot give a compensator"}
    commandline.add_options(
        group, absent, choices=("encoder", "motor_force"), **commandline.SEVERAL
    )
    force = "write the whole force of the compensator even if it is not recommended"
    commandline.add_options(group, {"--force": force}, **commandline.FLAG)


def _declare_expected(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--friction-range",
        nargs=2,
        type=commandline.positive,
        default=harm.levels(),
        metavar=("LEAST", "LARGEST"),
        help="friction that the drive may come to have, over that in the log; there, too, a "
        f"compensator must not be worse than none (default: {harm.FALLS:g} {harm.GROWS:g})",
    )
    motions = {
        "--motions FILE": "commands of motions that the drive will make, on which alone "
        "compensators are compared, such as logs or plans"
    }
    commandline.add_options(group, motions, type=Path, **commandline.SEVERAL)


def run(options: argparse.Namespace) -> Answer:
    """Check the log, learn, print the parameters, and write the results."""
    description = description_of(options)
    if options.rig is None:
        options.log = logs_given(options)
    elif options.check or options.log or options.log_option or description != type(description)():
        raise UsageError("--rig: expected no log, no description of one, and no --check")
    if options.compensator != "auto":
        require_parts(options.compensator)
    if options.check:
        from stickslip.identification.sliding.checked_logs import Checked, Refused, check_logs
        from stickslip.logs.sets import logs_of

        every: list[Finding] = []
        refused: list[RecordingError] = []
        logs = logs_of(options.log, description)
        for log, checked in zip(logs, check_logs(logs, alone=True), strict=True):
            one = checked
            if isinstance(one, Checked) and one.reading.controller.parameters():
                from stickslip.studies.learn.controller_findings import check_description

                one = replace(one, findings=check_description(one.reading, one.findings))
            refuses = isinstance(one, Refused)
            print(f"{log.path}: {_headline(one.findings, refused=refuses)}")
            TerminalProgress().findings(one.findings)
            every += one.findings
            if isinstance(one, Refused):
                refused.append(one.error)
                if not one.findings and len(logs) > 1:
                    print(f"error: {one.error}")
        if refused:
            raise refused[0]
        return Answer({"findings": [str(finding) for finding in every]})
    TerminalProgress().stage("loading what learning takes")
    from stickslip.studies.learn.folder import FILES
    from stickslip.trial.candidates import law_of

    law_of(options.compensator, options.law, options.without)
    with reserved(options.out, FILES):
        return Answer(_learn(options, description))


def _headline(findings: Sequence[Finding], *, refused: bool) -> str:
    """Return whether a log passes the checks; what learning finds may still refuse it."""
    errors, warnings = (
        sum(one.severity == severity for one in findings) for severity in ("error", "warning")
    )
    if errors or refused:
        return f"cannot be learned from; errors: {errors or 1}, warnings: {warnings}"
    return f"passes the checks; warnings: {warnings or 'none'}"


def _learn(options: argparse.Namespace, description: Description) -> dict[str, Any]:
    from stickslip.identification.estimation import Search
    from stickslip.studies.learn.document import log_document
    from stickslip.studies.learn.folder import write_learned
    from stickslip.studies.learn.log_learning import learn
    from stickslip.studies.learn.verdict import lines, verdict_of

    with (
        TerminalProgress(findings=options.verbose) as progress,
        rig_of(options.rig, options.out, options.law) as (rig, limits),
    ):
        learned = learn(
            rig or options.log,
            description,
            progress=progress,
            validate=options.validate or (),
            law=options.law,
            criterion=options.criterion,
            seed=options.seed,
            search=Search(options.algorithm, workers=options.workers),
            compensator=options.compensator,
            absent=options.without,
            motions=options.motions,
            friction_range=tuple(options.friction_range),
            limits=limits,
            fixed_gains=options.fixed_gains or options.force,
        )
        written = None
        if options.out:
            progress.stage("writing the results")
            written = write_learned(learned, options.out, force=options.force)
    verdict = written.verdict if written else verdict_of(learned)
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    print(*lines(verdict, options.out, width), sep="\n")
    if options.verbose:
        print_estimation(learned.estimation, learned.predicted)
        _print_trial(learned)
        for warning in learned.warnings:
            commandline.warn(warning)
        if written:
            _print_written(written)
        if learned.other_gains:
            print(learned.other_gains.sentence)
    return (written.document() if written else log_document(learned)) | {"folder": options.out}


def _print_trial(learned: LearnedFromRecording) -> None:
    """Print tracking errors, measured and simulated, and what compensators leave of them."""
    from stickslip.studies.learn import tables

    if tracking := learned.tracking:
        print(f"\ntracking error on {tracking.command}, in the loop of {tracking.loop}:")
        print(tables.tracking(tracking, learned.estimation.recording.motion).text())
    if learned.trial is None:
        return
    compared = learned.trial.compared
    print("\ntracking error relative to none, on the same simulated drives and motions:")
    print(tables.compensators(compared).text(), compared.sentence, sep="\n")
    if compared.chosen.benefit:
        print(tables.benefit_text(compared.chosen.benefit, compared.chosen.name))
    if learned.trial.holds:
        print("\nat rest, on the worst simulated drive:")
    for name, hold in learned.trial.holds.items():
        swing = f"swings by {1e6 * hold.swing:.3g} {hold.unit}"
        if not math.isfinite(hold.swing):
            swing = "runs away"
        print(
            f"{name:24} {swing}, {hold.reversals} reversals in {hold.duration:.3g} s; {hold.drive}"
        )


def _print_written(written: Written) -> None:
    """Print which FMUs are in the folder, and why others are not."""
    from stickslip.studies.learn.verdict import COMPENSATOR

    learned, files = written.learned, written.files
    told, *refused = written.sentences
    for sentence in refused:
        commandline.warn(sentence)
    benefit = learned.benefit
    if benefit and benefit.share < 1.0 and not learned.refusal and COMPENSATOR in files:
        part = f"{100 * benefit.share:g} % of the learned force"
        if written.forced:
            part = "the whole learned force, as --force asks for"
        print(f"{COMPENSATOR} has {part}; {benefit.reason}")
    print(told)


def print_estimation(estimation: Estimation, predicted: Sequence[PredictedLog] = ()) -> None:
    """Print criterion, parameters with intervals, and relative errors."""
    from stickslip.studies.learn import tables

    print(f"\ncriterion: {estimation.criterion} ({estimation.reason})")
    for remark in estimation.remarks:
        print(f"note: {remark}")
    for fault in estimation.faults:
        print(f"{fault}; no parameter is reported as identifiable" if fault.spoils else fault)
    print("\nforce error where the law was not fitted")
    print(tables.laws(estimation).text())
    if predicted:
        print("\nforce error of logs that were not learned from")
        print(tables.predicted_logs(predicted, rotary=estimation.recording.rotary).text())
    if estimation.choice:
        print(f"law: {estimation.choice.reason}")
    print()
    rotary = estimation.recording.rotary
    print(tables.parameters(estimation).text())
    for name, value in estimation.chosen.items():
        one = estimation.law.parameters[name]
        meant = "exponent of the Stribeck curve, 1 or 2" if name == "delta" else one.description
        print(f"{name:8} {value:12.6g} {one.unit:9} {meant}")
    force = unit_of("F_c", rotary=rotary)
    errors = estimation.errors
    for label, name, unit, what in (
        ("offset", "F_0", force, "constant force against the motor"),
        ("delay", "delay", "s", "delay of the force beyond that of the log"),
    ):
        error = f"; standard error {errors[name]:.2g}" if name in errors else ""
        print(f"{label:8} {estimation.parameters[name]:12.6g} {unit:9} {what}{error}")
    if estimation.position_force:
        print("\nforce of position, beside mass and friction")
        print(tables.position_force(estimation).text(), tables.HELD, sep="\n", end="\n\n")
    for name, value in estimation.figures.errors().items():
        if math.isfinite(value):
            print(f"relative error {100 * value:9.4g} %  {FIGURES[name]}")
