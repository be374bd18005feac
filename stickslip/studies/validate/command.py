"""``stickslip validate``: a learned drive against another log, or on a rig.

stickslip validate axis/learned.json --log other.csv
stickslip validate axis/learned.json --log with.csv --without plain.csv --out validated
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.commandline import add_options, log_options, require_files, warn, write_files
from stickslip.commandline.progress import TerminalProgress
from stickslip.errors import HarmfulError, UsageError
from stickslip.output import Answer
from stickslip.storage import reserved
from stickslip.storage.codec import encode

if TYPE_CHECKING:
    from stickslip.learned.file import LearnedFile


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "learned", nargs="?", type=Path, metavar="LEARNED", help="learned.json of the drive"
    )
    parser.add_argument("--parameters", dest="learned_option", type=Path, help=argparse.SUPPRESS)
    logs = {"--log FILE": "another log of the drive, which is compared with what was learned"}
    logs["--without FILE"] = (
        "--log was recorded with the compensator running, and this log without it: what it brought "
        "on the same command"
    )
    add_options(parser, logs, type=Path)
    log_options.add_rig_option(
        parser, "run a motion without and with the compensator on the drive of this file"
    )
    add_options(parser, {"--out DIR": "folder for tables, figures and page"}, type=Path)
    log_options.add_log_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Compare with a log, or run a motion on a rig."""
    file = log_options.one_of("a learned.json", options.learned, options.learned_option)
    require_files(options.log, options.without, options.rig)
    from stickslip.learned.file import LearnedFile
    from stickslip.studies.validate.page import comparison, log

    learned = LearnedFile(file)
    if options.rig:
        if options.log or options.without:
            raise UsageError("--rig: expected neither --log nor --without")
        return Answer(_on_rig(options, learned))
    if options.log is None:
        of = "--without: expected --log with a log of the same drive, compensated"
        raise UsageError(of if options.without else "expected --log FILE, or --rig FILE.toml")
    if options.without:
        with reserved(options.out, comparison.FILES):
            return Answer(_on_two_logs(options, learned))
    with reserved(options.out, log.FILES):
        return Answer(_on_log(options, learned))


def _on_log(options: argparse.Namespace, learned: LearnedFile) -> dict[str, Any]:
    from stickslip.studies.validate.log_validation import read_log, validate_log
    from stickslip.studies.validate.log_verdict import verdict
    from stickslip.studies.validate.page.log import write_log_validation
    from stickslip.studies.validate.tables import signals as errors_of

    log = read_log(
        options.log, log_options.description_of(options), learned, TerminalProgress().findings
    )
    found = validate_log(log, learned)
    first, *reasons = verdict(found, learned.drive)
    print(f"\nverdict: {first}", *(f"  {reason}" for reason in reasons), sep="\n")
    print("\nrecorded less predicted, RMS in SI units", errors_of(found).text(), sep="\n")
    if options.out:
        command = {"name": "validate", "log": log.reading.recording.source}
        write_log_validation(found, learned, log.controller, options.out, command=command)
        print(f"all results are in {options.out}; open report.html first")
    changes = encode(found.changes)
    signals = {
        name: encode(error) | {"ratio": error.ratio} for name, error in found.signals.items()
    }
    return {"verdict": first, "reasons": reasons, "signals": signals, "changes": changes}


def _on_two_logs(options: argparse.Namespace, learned: LearnedFile) -> dict[str, Any]:
    from stickslip.studies.validate.compared_logs import sentences
    from stickslip.studies.validate.log_validation import compare_logs, read_log
    from stickslip.studies.validate.page.comparison import write_comparison
    from stickslip.studies.validate.tables import tracking

    description = log_options.description_of(options)
    compensated, without = (
        read_log(path, description, learned) for path in (options.log, options.without)
    )
    found = compare_logs(compensated, without, learned)
    print(*sentences(found), sep="\n")
    print(f"\ntracking errors, intervals from {found.parts} parts")
    print(tracking(found).text())
    if options.out:
        logs = (without.reading.recording.source, compensated.reading.recording.source)
        write_comparison(found, logs, learned, without.controller, folder=options.out)
        print(f"all results are in {options.out}; open report.html first")
    compared = {"measured": found.measured, "simulated": found.simulated}
    reductions = {kind: encode(one.reductions) for kind, one in compared.items() if one}
    return {"sentences": sentences(found), "reductions": reductions}


def _on_rig(options: argparse.Namespace, learned: LearnedFile) -> dict[str, Any]:
    """Run the trapezoid of the file without and with its compensator, in the loop of the rig."""
    from stickslip.evaluation.validation import validate

    document = learned.document
    if refusal := document.get("refusal"):
        raise HarmfulError(f"{learned.path}: learn does not recommend it: {refusal}; not run")
    if {"observer", "feedforward"} & document.keys():
        law = learned.law.title
        warn(f"only the feedforward of the {law} law is tried, no other compensator of the file")
    compensator, command = learned.compensator, learned.validation
    with (
        reserved(options.out, ["validation.csv"]),
        log_options.rig_of(options.rig, options.out, learned.law.name) as (rig, _),
        TerminalProgress() as progress,
    ):
        if rig is None:
            raise UsageError("--rig: expected a file")
        progress.stage("validating")
        found = validate(rig, rig.loop, compensator, command)
    print(found)
    table = found.errors()
    about = {"name": "validate", "rig": str(options.rig), "parameters": compensator}
    files = {"validation.csv": table.to_csv(index=False, lineterminator="\n")}
    write_files(options.out, about, files)
    return {"validation": table}
