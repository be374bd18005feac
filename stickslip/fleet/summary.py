"""One table of a fleet: a row for each drive and parameter, and one for each drive that failed."""

from __future__ import annotations

from typing import Any

import pandas as pd

from stickslip.fleet.drive import Variant
from stickslip.fleet.study import Fleet
from stickslip.pipeline.reproduction import drive_truth

COLUMNS = [
    "name",
    "parameter",
    "unit",
    "value",
    "standard_error",
    "low",
    "high",
    "visible",
    "judge",
    "truth",
    "reason",
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
                "judge": document["judge"],
                "truth": truth.get(parameter),
            }
            for parameter, known in document["parameters"].items()
        ]
    return pd.DataFrame(rows, columns=COLUMNS)
