"""The table and the files of a fleet study."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from stickslip.fleet.study import TABLE, Fleet
from stickslip.fleet.table import Drive, Variant
from stickslip.fmi.files import atomic_write
from stickslip.pipeline.reproduction import drive_truth
from stickslip.report.drives import drives_sections
from stickslip.report.markup import Html, element, join, paragraph
from stickslip.report.page import picture_files, write_page
from stickslip.results.compared import PARAMETERS, parameter_rows
from stickslip.results.folder import completed

COLUMNS = [*PARAMETERS, "criterion", "source", "truth", "reason"]
PAGE = "fleet.html"


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
        write_page(staging, "Fleet", drives_sections(table, _head(fleet), "fleet"), PAGE)
        for name, document in fleet.learned.items():
            atomic_write(staging / _learned(name), json.dumps(document, indent=2) + "\n")


def _head(fleet: Fleet) -> Html:
    """Return how many drives were learned, and why others were not."""
    failed = [element("li", f"{name}: {reason}") for name, reason in fleet.reasons.items()]
    learned = paragraph(f"{len(fleet.learned)} of {len(fleet.drives)} drives were learned.")
    return join([learned, element("ul", join(failed, "\n"))]) if failed else learned


def _learned(name: str) -> str:
    return f"drives/{name}/learned.json"
