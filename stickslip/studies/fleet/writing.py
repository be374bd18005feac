"""The table and the files of a fleet study."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from stickslip.fmi.files import atomic_write
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.papers.lugre.reproduction import drive_truth
from stickslip.presentation.markup import Html, element, join, paragraph
from stickslip.presentation.markup import table as markup_table
from stickslip.presentation.page import Section, picture_files, write_page
from stickslip.presentation.quantity import number, symbol
from stickslip.storage import completed
from stickslip.studies.compare.compared import PARAMETERS, error_ratios, parameter_rows
from stickslip.studies.compare.page import drives_sections, readable_unit
from stickslip.studies.fleet.study import TABLE, Fleet
from stickslip.studies.fleet.table import Drive, Variant

COLUMNS = [*PARAMETERS, "criterion", "source", "truth", "reason"]
PAGE = "fleet.html"
SUMMARY = ["parameter", "unit", "drives", "minimum", "median", "maximum"]


def fleet_table(fleet: Fleet) -> pd.DataFrame:
    """Return what was learned, in SI units; the truth of variants enters here only.

    ``low`` and ``high`` bound the 95 % interval. A drive that failed has its name and the reason.
    """
    rows: list[dict[str, Any]] = []
    for drive in fleet.drives:
        if drive.name in fleet.reasons:
            rows.append({"name": drive.name, "reason": fleet.reasons[drive.name]})
            continue
        document = fleet.learned[drive.name]
        truth = drive_truth(drive.source.changes) if isinstance(drive.source, Variant) else {}
        further = {"criterion": document["criterion"], "source": drive.kind}
        rows += [
            {**row, **further, "truth": truth.get(row["parameter"])}
            for row in parameter_rows(drive.name, document["parameters"])
        ]
    return pd.DataFrame(rows, columns=COLUMNS)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Return each parameter over the drives in which it is identifiable.

    A row for each parameter and unit, with the number of drives, minimum, median and maximum.
    """
    seen = table[table["parameter"].notna() & (table["identifiability"] != NOT_IDENTIFIABLE)]
    rows = [
        (name, unit, len(of), of["value"].min(), of["value"].median(), of["value"].max())
        for (name, unit), of in seen.groupby(["parameter", "unit"], sort=False)
    ]
    return pd.DataFrame(rows, columns=SUMMARY)


def files_of(drives: Sequence[Drive]) -> list[str]:
    """Return the names of the files that ``write_fleet`` writes or removes."""
    learned = (_learned(drive.name) for drive in drives)
    return [TABLE, "fleet.json", PAGE, *picture_files(["fleet"]), *learned]


def write_fleet(fleet: Fleet, table: pd.DataFrame, folder: Path) -> None:
    """Write fleet.csv, fleet.json, drives/NAME/learned.json, and a page with a figure.

    Raises
    ------
    UsageError, OSError
        As ``results.folder.staged``.
    """
    names = [drive.name for drive in fleet.drives]
    known = {name: fleet.learned.get(name) or {"reason": fleet.reasons[name]} for name in names}
    command = {"name": "fleet", "drives": names}
    with completed(folder, command, files_of(fleet.drives), {TABLE: table}) as staging:
        atomic_write(staging / "fleet.json", json.dumps({"drives": known}, indent=2) + "\n")
        write_page(staging, "Fleet", _sections(fleet, table), PAGE)
        for name, document in fleet.learned.items():
            atomic_write(staging / _learned(name), json.dumps(document, indent=2) + "\n")


def _sections(fleet: Fleet, table: pd.DataFrame) -> list[Section]:
    """Return the sections of the page; what compensators bring is there where it was tried."""
    errors = pd.DataFrame(
        [{"name": name, **error_ratios(document)} for name, document in fleet.learned.items()]
    )
    tried = len(errors) and errors["fitted"].notna().any()
    head, over = _head(fleet), summary(table)
    if len(over):
        rows = []
        for name, SI, drives, *values in over.itertuples(index=False, name=None):
            factor, unit = readable_unit(name, SI)
            rows.append((symbol(name), unit, str(drives), *(number(factor * v) for v in values)))
        title = "Parameters over the drives in which they are identifiable"
        head = join([head, markup_table(SUMMARY, rows, title, (0, 1))])
    return drives_sections(table, head, "fleet", errors if tried else None)


def _head(fleet: Fleet) -> Html:
    """Return how many drives were learned, and why others were not."""
    failed = [element("li", f"{name}: {reason}") for name, reason in fleet.reasons.items()]
    learned = paragraph(f"{len(fleet.learned)} of {len(fleet.drives)} drives were learned.")
    return join([learned, element("ul", join(failed, "\n"))]) if failed else learned


def _learned(name: str) -> str:
    return f"drives/{name}/learned.json"
