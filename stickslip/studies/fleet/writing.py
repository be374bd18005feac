"""The table and the files of a fleet study."""

from collections.abc import Sequence
from math import isnan
from pathlib import Path
from statistics import median
from typing import Any

from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.presentation.markup import fill
from stickslip.presentation.page import picture_files, write_page
from stickslip.presentation.table import Column, Table
from stickslip.storage import completed
from stickslip.storage.writing import write_json
from stickslip.studies.compare.compared import error_ratios, parameter_rows
from stickslip.studies.compare.page import drives_sections
from stickslip.studies.compare.tables import ERRORS, PARAMETER, PARAMETERS, UNIT, value_column
from stickslip.studies.fleet.study import TABLE, Fleet
from stickslip.studies.fleet.table import Drive

COLUMNS = (*PARAMETERS, *map(Column, ("criterion", "reason")))
SUMMARY = (
    PARAMETER,
    UNIT,
    Column("drives", text="d", title="drives", head="drives"),
    *map(value_column, ("minimum", "median", "maximum")),
)
"""A row for each parameter and unit, over the drives in which it is identifiable."""
PAGE, SUMMARY_TABLE = "fleet.html", "summary.csv"


def fleet_table(fleet: Fleet) -> Table:
    """Return what was learned in SI units, with 95 % intervals; of a failure name and reason."""
    rows: list[dict[str, Any]] = []
    for drive in fleet.drives:
        if drive.name in fleet.reasons:
            rows.append({"name": drive.name, "reason": fleet.reasons[drive.name]})
            continue
        document = fleet.learned[drive.name]
        own = parameter_rows(drive.name, document["parameters"])
        rows += [{**row, "criterion": document["criterion"]} for row in own]
    return Table(COLUMNS, rows)


def summary(table: Table) -> Table:
    """Return each parameter over the drives in which it is identifiable."""
    found: dict[tuple[str, str], list[float]] = {}
    for row in table.rows:
        if row.get("identifiability", NOT_IDENTIFIABLE) != NOT_IDENTIFIABLE:
            found.setdefault((row["parameter"], row["unit"]), []).append(row["value"])
    rows = [
        (name, unit, len(values), min(values), median(values), max(values))
        for (name, unit), values in found.items()
    ]
    keys = [column.name for column in SUMMARY]
    return Table(SUMMARY, [dict(zip(keys, row, strict=False)) for row in rows])


def files_of(drives: Sequence[Drive]) -> list[str]:
    """Return the names of the files that ``write_fleet`` writes or removes."""
    learned = (_learned(drive.name) for drive in drives)
    return [TABLE, SUMMARY_TABLE, "fleet.json", PAGE, *picture_files(["fleet"]), *learned]


def write_fleet(fleet: Fleet, table: Table, folder: Path) -> None:
    """Write fleet.csv, fleet.json, drives/NAME/learned.json, and a page with a figure."""
    names = [drive.name for drive in fleet.drives]
    known = {name: fleet.learned.get(name) or {"reason": fleet.reasons[name]} for name in names}
    command = {"name": "fleet", "drives": names}
    tables = {TABLE: table.frame(), SUMMARY_TABLE: summary(table).frame()}
    # What compensators bring is on the page where it was tried.
    rows = [{"name": name, **error_ratios(document)} for name, document in fleet.learned.items()]
    errors = Table(ERRORS, rows) if any(not isnan(row["fitted"]) for row in rows) else None
    with completed(folder, command, files_of(fleet.drives), tables) as staging:
        write_json({"drives": known}, staging / "fleet.json")
        head = fill("studies/fleet/head.j2", fleet=fleet, over=summary(table))
        write_page(staging, "Fleet", drives_sections(table, head, "fleet", errors), PAGE)
        for name, document in fleet.learned.items():
            write_json(document, staging / _learned(name))


def _learned(name: str) -> str:
    return f"drives/{name}/learned.json"
