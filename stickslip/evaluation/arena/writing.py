"""The files of an arena."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from stickslip.evaluation.arena.page import FIGURES, TITLE, sections
from stickslip.evaluation.arena.protocol import UNFINISHED, Arena
from stickslip.evaluation.arena.table import time_table
from stickslip.evaluation.arena.winners import write_winners
from stickslip.fmi.files import atomic_write
from stickslip.report.page import picture_files, write_page
from stickslip.results.folder import remove_results, staged

TABLE, TIMES, PAGE = "arena.csv", "time.csv", "arena.html"
FILES = (TABLE, TIMES, PAGE, *picture_files(FIGURES))


def write_arena(arena: Arena, table: pd.DataFrame, folder: Path) -> None:
    """Write tables, arena.html with its figures and the winners; remove what was kept meanwhile.

    Raises
    ------
    UsageError
        When a file to be replaced is the user's.
    OSError
        When a file cannot be written.
    """
    plan = arena.plan
    command = {
        "name": "arena",
        "drives": [drive.name for drive in plan.drives],
        "compensators": list(plan.entrants),
    }
    with staged(folder, command, without=FILES) as staging:
        write_page(staging, TITLE, sections(arena, table), PAGE)
        write_winners(arena, table, staging)
        for name, content in ((TABLE, table), (TIMES, time_table(arena))):
            atomic_write(staging / name, content.to_csv(index=False, lineterminator="\n"))
    remove_results(folder / UNFINISHED)
