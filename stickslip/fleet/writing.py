"""The files of a fleet study."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pandas as pd

from stickslip.fleet.picture import draw_fleet
from stickslip.fleet.study import TABLE, UNFINISHED, Fleet
from stickslip.result_folder import staged
from toolchain import write_whole

PICTURES = ("png", "svg")


def write_fleet(fleet: Fleet, table: pd.DataFrame, folder: Path) -> None:
    """Write fleet.csv, fleet.json, drives/NAME/learned.json and pictures, if a drive was learned.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    names = [drive.name for drive in fleet.drives]
    known = {name: fleet.learned.get(name) or {"reason": fleet.reasons[name]} for name in names}
    paths = {name: f"drives/{name}/learned.json" for name in names}
    pictures = draw_fleet(table) if fleet.learned else {}
    files = (*paths.values(), *(f"fleet.{kind}" for kind in PICTURES))
    with staged(folder, {"name": "fleet", "drives": names}, without=files) as desk:
        write_whole(desk / "fleet.json", json.dumps({"drives": known}, indent=2) + "\n")
        for kind, picture in pictures.items():
            write_whole(desk / f"fleet.{kind}", picture)
        for name, document in fleet.learned.items():
            write_whole(desk / paths[name], json.dumps(document, indent=2) + "\n")
        write_whole(desk / TABLE, table.to_csv(index=False, lineterminator="\n"))
    shutil.rmtree(folder / UNFINISHED, ignore_errors=True)
