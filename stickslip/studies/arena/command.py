"""``stickslip arena``: compare all compensators on drives of all friction laws.

stickslip arena --seeds 1 --out arena
stickslip arena --drive axis/learned.json --compensators static ekbf --out arena
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip import models
from stickslip.commandline import FLAG, SEVERAL, add_options, at_least, complete_with, require_files
from stickslip.commandline.execution import add_worker_options
from stickslip.commandline.progress import TerminalProgress
from stickslip.compensators.names import part_names, require_parts
from stickslip.errors import UsageError
from stickslip.output import Answer
from stickslip.storage import reserved
from stickslip.studies.arena import STARTS, TUNINGS, Budget
from stickslip.studies.arena.drive_names import drive_names, require_drives
from stickslip.work.jobs import Execution

if TYPE_CHECKING:
    from stickslip.studies.arena.protocol import Cell, Plan


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Tune every compensator on every drive, with the same algorithm and budget and from"
        " measured signals only, and validate it on motions that it was not tuned on. Writes"
        " arena.csv.gz, arena.html, and the winner of each drive as FMU, C and structured text."
    )
    laws = f"only drives with these friction laws: {', '.join(models.law_names())}"
    add_options(parser, {"--laws LAW": laws}, choices=models.law_names(), **SEVERAL)
    names = "what competes, such as pi, static or lugre+ekbf (default: all)"
    named = parser.add_argument("--compensators", metavar="NAME", help=names, **SEVERAL)
    complete_with(named, part_names)
    add_options(parser, {"--drives FILE.toml": "drives instead of the default ones"}, type=Path)
    learned = "a learned drive instead of the default ones, or beside those of --drives"
    add_options(parser, {"--drive learned.json": learned}, type=Path, **SEVERAL)
    own = {"--compensator FILE.fmu": "a compensator of your own, beside the others"}
    add_options(parser, own, type=Path, **SEVERAL)
    ports = {"--ports FILE.toml": "how it is connected, one for each --compensator"}
    add_options(parser, ports, type=Path, **SEVERAL)
    only = "only these drives, by name"
    chosen = parser.add_argument("--only", metavar="DRIVE", help=only, **SEVERAL)
    complete_with(chosen, drive_names)
    starts = "runs of each command, with other noise and another place between encoder steps"
    add_options(parser, {"--seeds N": starts}, type=at_least(1), default=STARTS)
    evaluations = "budget of each compensator on each drive: candidates"
    add_options(
        parser, {"--evaluations N": evaluations}, type=at_least(10), default=Budget().evaluations
    )
    seconds = "budget of each compensator on each drive: motion of the drive [s]"
    add_options(parser, {"--seconds S": seconds}, type=float, default=Budget().seconds)
    seed = {"--seed": "random seed of the algorithm and of the coarse start values"}
    add_options(parser, seed, type=at_least(0), default=0)
    tunings = "random seeds, from --seed on, of entrants whose rank moves with the seed"
    add_options(parser, {"--tunings N": tunings}, type=at_least(1), default=TUNINGS)
    add_worker_options(parser, "cells")
    parser.set_defaults(where="processes")
    resume = "keep what an interrupted run has found with the same options"
    add_options(parser, {"--resume": resume}, **FLAG)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Run the arena, write its files and print the ranking; status 1 if a cell failed."""
    plan = _plan(options)
    from stickslip.studies.arena.protocol import run_arena
    from stickslip.studies.arena.table import arena_table, entrant_table
    from stickslip.studies.arena.writing import FILES, write_arena

    with reserved(options.out, FILES), TerminalProgress() as progress:
        cells = len(plan.drives) * len(plan.entrants)

        def on_done(done: int, of: int, cell: Cell) -> None:
            progress.done(done, of, cell.name, "cell")

        progress.stage(f"{cells} cells: {len(plan.entrants)} entrants on {len(plan.drives)} drives")
        progress.move(0, cells, "cell")
        arena = run_arena(
            plan,
            options.out,
            Execution(options.workers, options.where, resume=options.resume),
            on_done,
        )
        table = arena_table(arena)
        write_arena(arena, table, options.out)
    ranking = entrant_table(table, arena.plan)
    print(f"errors relative to {arena.plan.reference}: geometric mean and worst over the drives")
    print(ranking.text())
    for (drive, name), reason in arena.reasons.items():
        print(f"{name} on {drive} failed: {reason}")
    print(f"all results are in {options.out}; open arena.html first")
    failed = [{"drive": d, "entrant": n, "reason": r} for (d, n), r in arena.reasons.items()]
    document = {"folder": options.out, "table": table, "ranking": ranking, "failed": failed}
    return Answer(document, 1 if failed else 0)


def _plan(options: argparse.Namespace) -> Plan:
    """Return what the options choose."""
    require_files(options.drives, *options.drive, *options.compensator, *options.ports)
    if not (options.drives or options.drive):
        require_drives(options.only, drive_names())
    if not options.compensator:  # else names of the user's own count, too
        for name in options.compensators or ():
            require_parts(name)
    from stickslip.studies.arena.comparison import make_plan

    if len(options.compensator) != len(options.ports):
        raise UsageError("--compensator and --ports: expected one file of ports for each FMU")
    names = ("laws", "only", "evaluations", "seconds", "seeds", "seed", "tunings")
    given = {name: getattr(options, name) for name in names}
    own = dict(zip(options.compensator, options.ports, strict=True))
    return make_plan(options.compensators, options.drives, learned=options.drive, own=own, **given)
