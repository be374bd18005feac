"""The files of an arena."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from stickslip.evaluation.arena.page import FIGURES, TITLE, sections
from stickslip.evaluation.arena.protocol import Arena
from stickslip.evaluation.arena.table import time_table
from stickslip.evaluation.arena.winners import write_winners
from stickslip.report.page import picture_files, write_page
from stickslip.results.folder import completed

TABLE, TIMES, PAGE = "arena.csv", "time.csv", "arena.html"
FILES = (TABLE, TIMES, PAGE, *picture_files(FIGURES))


def write_arena(arena: Arena, table: pd.DataFrame, folder: Path) -> None:
    """Write tables, arena.html with its figures and the winners; remove what was kept meanwhile.

    Raises
    ------
    UsageError, OSError
        As ``results.folder.staged``.
    """
    plan = arena.plan
    command = {
        "name": "arena",
        "drives": [drive.name for drive in plan.drives],
        "compensators": list(plan.entrants),
    }
    with completed(folder, command, FILES, {TABLE: table, TIMES: time_table(arena)}) as staging:
        write_page(staging, TITLE, sections(arena, table), PAGE)
        write_winners(arena, table, staging)
