"""``stickslip fleet``: learn many drives at once, from a table of logs or drive variants."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from stickslip.commands.execution import add_worker_options
from stickslip.commands.progress import TerminalProgress
from stickslip.errors import UsageError
from stickslip.fleet import Drive, Fleet, fleet_table, learn_fleet, read_fleet
from stickslip.fleet.job import Outcome
from stickslip.fleet.writing import files_of, write_fleet
from stickslip.results.folder import reserved
from stickslip.tuning.execution import Execution

VISIBLE = ("well known", "weakly known", "not visible")


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Learn the drives of a table in parallel. TABLE is a CSV file with a row "
        "for each drive: its name, and either log, with config, a TOML file that describes the "
        "log (both relative to the table), or set, parameters of a simulated drive that is then "
        "recorded, such as 'drive.m=10 drive.noise=on'."
    )
    parser.add_argument("table", type=Path, metavar="TABLE")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        help="random seed of the genetic algorithm, the same for each drive",
    )
    add_worker_options(parser, "drives")
    parser.add_argument(
        "--resume",
        action="store_true",
        help="keep what an earlier run learned from the same rows, files, seed and versions",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Learn all drives, write the results, say what is known; return 1 if a drive failed."""
    if options.seed < 0 or options.workers < 1:
        raise UsageError(
            f"--seed must be at least 0 and --workers at least 1, got {options.seed} and "
            f"{options.workers}"
        )
    drives = read_fleet(options.table)
    with reserved(options.out, files_of(drives)):
        return _learn(options, drives)


def _learn(options: argparse.Namespace, drives: Sequence[Drive]) -> int:
    execution = Execution(options.workers, options.where, resume=options.resume)
    with TerminalProgress(sys.stderr) as progress:
        done = 0

        def tell(drive: Drive, outcome: Outcome) -> None:
            nonlocal done
            done += 1
            progress.stage(f"{done}: {drive.name} {outcome.reason or 'learned'}")

        progress.stage(f"learning {len(drives)} drives")
        fleet = learn_fleet(
            drives, options.out, seed=options.seed, execution=execution, on_done=tell
        )
    table = fleet_table(fleet)
    write_fleet(fleet, table, options.out)
    _print_drives(fleet)
    _print_parameters(table)
    if fleet.kept:
        print(f"{fleet.kept} of {len(drives)} drives were learned before and kept")
    print(f"all results are in {options.out}; open fleet.png first")
    if not fleet.reasons:
        return 0
    print(
        f"stickslip: {len(fleet.reasons)} of {len(drives)} drives failed; the reasons are above "
        f"and in {options.out / 'fleet.csv'}",
        file=sys.stderr,
    )
    return 1


def _print_drives(fleet: Fleet) -> None:
    """Print by what each drive was judged and how well what is known."""
    width = max(len(drive.name) for drive in fleet.drives)
    for drive in fleet.drives:
        if drive.name in fleet.reasons:
            print(f"{drive.name:{width}}  failed: {fleet.reasons[drive.name]}")
            continue
        document = fleet.learned[drive.name]
        known: dict[str, list[str]] = {visible: [] for visible in VISIBLE}
        for name, parameter in document["parameters"].items():
            known[parameter["visible"]].append(name)
        said = "; ".join(f"{visible}: {' '.join(of)}" for visible, of in known.items() if of)
        print(f"{drive.name:{width}}  {document['judge']}; {said}")


def _print_parameters(table: pd.DataFrame) -> None:
    """Print each parameter's range over the drives in which it is visible."""
    seen = table[table["parameter"].notna() & (table["visible"] != VISIBLE[-1])]
    if seen.empty:
        return
    heads = ("minimum", "median", "maximum")
    print(f"\n{'':8} {'':9} {'drives':>6} " + " ".join(f"{head:>11}" for head in heads))
    for (name, unit), of in seen.groupby(["parameter", "unit"], sort=False):
        value = of["value"]
        figures = (value.min(), value.median(), value.max())
        numbers = " ".join(f"{figure:11.5g}" for figure in figures)
        print(f"{name:8} {unit:9} {len(of):6} {numbers}")
    print()
