"""The files of an arena."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from stickslip.presentation.page import picture_files, write_page
from stickslip.storage import completed
from stickslip.studies.arena.page import FIGURES, TITLE, sections
from stickslip.studies.arena.protocol import Arena
from stickslip.studies.arena.table import entrant_table, time_table
from stickslip.studies.arena.winners import write_winners

TABLE, RANKING, TIMES = "arena.csv", "ranking.csv", "time.csv"
PAGE = "arena.html"
FILES = (TABLE, RANKING, TIMES, PAGE, *picture_files(FIGURES))


def write_arena(arena: Arena, table: pd.DataFrame, folder: Path) -> None:
    """Write tables, arena.html with its figures and the winners; remove what was kept meanwhile.

    Raises UsageError, OSError as ``results.folder.staged``.
    """
    plan = arena.plan
    command = {
        "name": "arena",
        "drives": [drive.name for drive in plan.drives],
        "compensators": list(plan.entrants),
    }
    ranking = entrant_table(table, plan).frame()
    tables = {TABLE: table, RANKING: ranking, TIMES: time_table(arena)}
    with completed(folder, command, FILES, tables) as staging:
        write_page(staging, TITLE, sections(arena, table), PAGE)
        write_winners(arena, table, staging)
