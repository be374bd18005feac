"""The files of an arena; the best compensator of each drive as FMU, C and structured text."""

from __future__ import annotations

import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from stickslip import models
from stickslip.models.firmware import write_compensator
from stickslip.presentation.page import picture_files, write_page
from stickslip.storage import completed
from stickslip.storage.codec import encode
from stickslip.storage.writing import write_json
from stickslip.studies.arena.drives import Drive
from stickslip.studies.arena.page import FIGURES, TITLE, sections
from stickslip.studies.arena.protocol import Arena
from stickslip.studies.arena.table import entrant_table, relative_errors, time_table
from stickslip.studies.arena.tuning import TuningResult
from stickslip.thresholds import offer

TABLE, RANKING, TIMES = "arena.csv.gz", "ranking.csv", "time.csv"
PAGE, FOLDER = "arena.html", "winners"
FILES = (TABLE, "arena.csv", RANKING, TIMES, PAGE, *picture_files(FIGURES))
"""What ``write_arena`` writes, or removes, as the table of older versions."""


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


def winners(arena: Arena, found: pd.DataFrame) -> dict[str, str]:
    """Return the entrant with the smallest error on each drive, of those within the limit of Ms."""
    errors = relative_errors(found, arena.plan, carried=False)
    chosen = {}
    for drive in arena.plan.drives:
        ranked = errors[drive.name].dropna().sort_values(kind="stable")
        for name in map(str, ranked.index):
            peaks = arena.documents[drive.name, name]["validated"][drive.name]["peaks"]
            if peaks.get("Ms", np.inf) <= offer.SENSITIVITY:
                chosen[drive.name] = name
                break
    return chosen


def write_winners(arena: Arena, found: pd.DataFrame, folder: Path) -> None:
    """Write ``winners/DRIVE/``: winner.json and, for each compensator, NAME.fmu, .c, .h and .st.

    Structured text is left out where the compensator has none. Raises OSError when a file cannot be
    written.
    """
    drives = {drive.name: drive for drive in arena.plan.drives}
    errors = relative_errors(found, arena.plan, carried=False)
    for drive, name in winners(arena, found).items():
        _write(arena, drives[drive], name, float(errors[drive][name]), folder / FOLDER / drive)


def _write(arena: Arena, drive: Drive, name: str, error: float, folder: Path) -> None:
    one, loop = arena.plan.entrant(name), drive.loop
    tuned_on = TuningResult.read(arena.documents[drive.name, name]["tuned"][drive.name])
    tuned = tuned_on.tuned(one, loop, drive.sheet)
    folder.mkdir(parents=True)
    components = {}
    for part in one.parts:
        compensator = part.compensator
        if compensator is None:
            continue
        own = {
            key.partition(".")[2]: value
            for key, value in tuned.parameters.items()
            if key.partition(".")[0] == part.name
        }
        start = {key: float(x) for key, x in {**compensator.parameters(loop), **own}.items()}
        law = part.law.name if part.law else None
        components[part.name] = {"model": part.model, "law": law, "parameters": start}
        if part.own_fmu is not None:
            shutil.copy(part.own_fmu, folder / f"{part.name}.fmu")
            continue
        given: dict[str, Any] = {"start": start, "law": law, "called": part.name}
        models.build_fmu(part.model, folder, **given)
        write_compensator(folder, "c", model=part.model, **given)
        with suppress(models.UnknownModel):  # it has no structured text
            write_compensator(folder, "st", model=part.model, **given)
    document = {
        "compensator": name,
        "drive": drive.name,
        "relative_error": error,
        "controller": {"K_p": tuned.loop.K_p, "K_i": tuned.loop.K_i},
        "components": components,
        "tuned": encode(tuned_on),
    }
    write_json(document, folder / "winner.json")
