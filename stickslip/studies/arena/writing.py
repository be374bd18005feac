"""The files of an arena; the best compensator of each drive as FMU, C and structured text."""

import shutil
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

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
from stickslip.studies.arena.table import entrant_table, relative_errors, robust
from stickslip.studies.arena.tuning import TuningResult

TABLE, RANKING = "arena.csv.gz", "ranking.csv"
PAGE, FOLDER = "arena.html", "winners"
FILES = (TABLE, RANKING, PAGE, *picture_files(FIGURES))
"""What ``write_arena`` writes."""


def write_arena(arena: Arena, table: pd.DataFrame, folder: Path) -> None:
    """Write tables, arena.html with its figures and the winners; remove what was kept meanwhile.

    A winner is the entrant with the smallest error on a drive, of those within the limit of Ms; it
    is in ``winners/DRIVE/``: winner.json and, for each compensator, NAME.fmu, .c, .h and .st.
    """
    plan = arena.plan
    drives, entrants = [drive.name for drive in plan.drives], list(plan.entrants)
    command = {"name": "arena", "drives": drives, "compensators": entrants}
    command |= {name: getattr(plan, name) for name in ("starts", "tunings", "seed")}
    command |= asdict(plan.budget)
    ranking = entrant_table(table, plan).frame()
    tables = {TABLE: table, RANKING: ranking}
    errors, within = relative_errors(table, plan, carried=False), robust(table)
    with completed(folder, command, FILES, tables) as staging:
        write_page(staging, TITLE, sections(plan, table), PAGE)
        for drive in plan.drives:
            ranked = errors[drive.name].dropna().sort_values(kind="stable")
            names = [n for n in ranked.index if (drive.name, n, drive.name) in within]
            for name in names[:1]:
                error = float(ranked[name])
                _write_winner(arena, drive, name, error, staging / FOLDER / drive.name)


def _write_winner(arena: Arena, drive: Drive, name: str, error: float, folder: Path) -> None:
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
