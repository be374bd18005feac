"""The files of a fleet, beside the learned.json of each drive."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd

from stickslip.fleet.picture import draw_fleet
from stickslip.fleet.study import TABLE, Fleet
from toolchain import write_whole


def write_fleet(fleet: Fleet, table: pd.DataFrame, folder: Path) -> None:
    """Write fleet.json, fleet.png, fleet.svg and, last of all, fleet.csv.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    drives = {
        drive.name: fleet.learned.get(drive.name) or {"reason": fleet.reasons[drive.name]}
        for drive in fleet.drives
    }
    write_whole(folder / "fleet.json", json.dumps({"drives": drives}, indent=2) + "\n")
    pictures = draw_fleet(table) if fleet.learned else {}
    for kind in ("png", "svg"):
        path = folder / f"fleet.{kind}"
        if kind in pictures:
            write_whole(path, pictures[kind])
        else:
            path.unlink(missing_ok=True)
    write_whole(folder / TABLE, table.to_csv(index=False, lineterminator="\n"))
