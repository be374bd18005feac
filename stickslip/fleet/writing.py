"""The table and the files of a fleet study."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from stickslip.fleet.picture import draw_fleet
from stickslip.fleet.study import TABLE, Fleet
from stickslip.fleet.table import Drive, Variant
from stickslip.fmi.files import atomic_write
from stickslip.pipeline.reproduction import drive_truth
from stickslip.report.page import picture_files
from stickslip.results.folder import completed

COLUMNS = [
    *("name", "parameter", "unit", "value", "standard_error", "low", "high", "identifiability"),
    *("criterion", "source", "truth", "reason"),
]


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
        rows += [
            {
                "name": drive.name,
                "parameter": parameter,
                **{column: known[column] for column in COLUMNS[2:8]},
                "criterion": document["criterion"],
                "source": drive.kind,
                "truth": truth.get(parameter),
            }
            for parameter, known in document["parameters"].items()
        ]
    return pd.DataFrame(rows, columns=COLUMNS)


def files_of(drives: Sequence[Drive]) -> list[str]:
    """Return the names of the files that ``write_fleet`` writes or removes."""
    learned = (_learned(drive.name) for drive in drives)
    return [TABLE, "fleet.json", *picture_files(["fleet"]), *learned]


def write_fleet(fleet: Fleet, table: pd.DataFrame, folder: Path) -> None:
    """Write fleet.csv, fleet.json, drives/NAME/learned.json and pictures, if a drive was learned.

    Raises
    ------
    UsageError, OSError
        As ``results.folder.staged``.
    """
    names = [drive.name for drive in fleet.drives]
    known = {name: fleet.learned.get(name) or {"reason": fleet.reasons[name]} for name in names}
    pictures = draw_fleet(table) if fleet.learned else {}
    command = {"name": "fleet", "drives": names}
    with completed(folder, command, files_of(fleet.drives), {TABLE: table}) as staging:
        atomic_write(staging / "fleet.json", json.dumps({"drives": known}, indent=2) + "\n")
        for kind, picture in pictures.items():
            atomic_write(staging / f"fleet.{kind}", picture)
        for name, document in fleet.learned.items():
            atomic_write(staging / _learned(name), json.dumps(document, indent=2) + "\n")


def _learned(name: str) -> str:
    return f"drives/{name}/learned.json"
