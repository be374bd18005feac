"""``stickslip fleet``: learn many drives at once, from a table of logs.

stickslip fleet logs.csv --out fleet
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.commandline import FLAG, add_options, at_least, require_files
from stickslip.commandline.execution import add_worker_options
from stickslip.commandline.progress import TerminalProgress
from stickslip.output import Answer
from stickslip.storage import reserved
from stickslip.work.jobs import Execution

if TYPE_CHECKING:
    from stickslip.studies.fleet.study import Fleet
    from stickslip.studies.fleet.table import Drive
    from stickslip.work.jobs import Outcome


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Learn the drives of a table in parallel. TABLE is a CSV file with a row "
        "for each drive: its name, its log and, if needed, config, a TOML file that describes the "
        "log; both are relative to the table."
    )
    parser.add_argument("table", type=Path, metavar="TABLE")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    seed = {"--seed": "random seed of the genetic algorithm, the same for each drive"}
    add_options(parser, seed, type=at_least(0), default=0)
    add_worker_options(parser, "drives")
    resume = "keep what an earlier run learned from the same rows, files, seed and versions"
    add_options(parser, {"--resume": resume}, **FLAG)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Learn all drives, write the results, print what is known; status 1 if a drive failed."""
    require_files(options.table)
    from stickslip.studies.fleet.table import read_fleet
    from stickslip.studies.fleet.writing import files_of

    drives = read_fleet(options.table)
    with reserved(options.out, files_of(drives)):
        return _learn(options, drives)


def _learn(options: argparse.Namespace, drives: Sequence[Drive]) -> Answer:
    from stickslip.studies.fleet.study import learn_fleet
    from stickslip.studies.fleet.writing import fleet_table, summary, write_fleet

    execution = Execution(options.workers, options.where, resume=options.resume)
    with TerminalProgress() as progress:
        done = 0

        def on_done(drive: Drive, outcome: Outcome) -> None:
            nonlocal done
            done += 1
            progress.done(done, len(drives), f"{drive.name} {outcome.reason or 'learned'}", "drive")

        progress.stage(f"learning {len(drives)} drives")
        progress.move(0, len(drives), "drive")
        fleet = learn_fleet(
            drives, options.out, seed=options.seed, execution=execution, on_done=on_done
        )
    table = fleet_table(fleet)
    write_fleet(fleet, table, options.out)
    _print_drives(fleet)
    over = summary(table)
    if over.rows:
        print(f"\n{over.text()}\n")
    if fleet.kept:
        print(f"{fleet.kept} of {len(drives)} drives were learned before and kept")
    print(f"all results are in {options.out}; open fleet.html first")
    document = {"folder": options.out, "table": table, "summary": over, "failed": fleet.reasons}
    if not fleet.reasons:
        return Answer(document)
    print(
        f"stickslip: {len(fleet.reasons)} of {len(drives)} drives failed; the reasons are above "
        f"and in {options.out / 'fleet.csv'}",
        file=sys.stderr,
    )
    return Answer(document, 1)


def _print_drives(fleet: Fleet) -> None:
    """Print the criterion of each drive and the identifiability of its parameters."""
    from stickslip.identification.fitting.identifiability import LEVELS

    width = max(len(drive.name) for drive in fleet.drives)
    for drive in fleet.drives:
        if drive.name in fleet.reasons:
            print(f"{drive.name:{width}}  failed: {fleet.reasons[drive.name]}")
            continue
        document = fleet.learned[drive.name]
        known: dict[str, list[str]] = {level: [] for level in LEVELS}
        for name, parameter in document["parameters"].items():
            known[parameter["identifiability"]].append(name)
        parameters = [f"{level}: {' '.join(of)}" for level, of in known.items() if of]
        print(f"{drive.name:{width}}  {'; '.join([document['criterion'], *parameters])}")
