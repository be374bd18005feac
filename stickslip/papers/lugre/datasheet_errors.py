"""What is known before any experiment, and what comes out when it is wrong.

Identification and learning see a drive through its measurements, but not only: the data sheet gives
them a few numbers. Each is varied here with the drive left as it is: identification, the paper's
loop with the identified compensator, and the same with a velocity filter.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from stickslip.catalog.estimate import HIGH, LOW
from stickslip.evaluation.scatter import PHASES
from stickslip.evaluation.validation import Validation, validate
from stickslip.fmi.errors import Fault
from stickslip.fmi.process import Threads
from stickslip.identification.stages import identify
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.datasheet import LOOP, Datasheet
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.paper_commands import VALIDATION
from stickslip.servo.systems import Feed

FACTORS: Mapping[str, tuple[float, ...]] = {
    "mass": (0.7,),
    "peak_force": (0.5,),
    "tau_i": (0.5, 3.0),
    "encoder_step": (2.0,),
    "force_noise": (5.0,),
}
"""How wrong each number of ``setup.Datasheet`` is taken to be."""
ENDS = ("", LOW, HIGH)
FOUND = ("m", "b", "F_c")
"""What is shown of the identification."""


def vary_datasheet(
    fmus: Path,
    feed: Feed,
    workers: int = 1,
    factors: Mapping[str, tuple[float, ...]] = FACTORS,
    law: str = "lugre",
) -> pd.DataFrame:
    """Return a row for the data sheet as it is, and one for each number in it that is wrong.

    Columns: quantity, factor, value; m, b, F_c as identified; the reductions of Table 4, measured,
    as ``start_E_max`` and so on; ``filtered``, the least of the four on the true velocity in the
    loop with velocity filter and feedforward of inertia; the ranges of these, see ``scatter.py``;
    ``error``, what failed. What was not reached is missing. Values are in SI units, reductions are
    fractions.

    Parameters
    ----------
    fmus : folder of drive.fmu and the FMUs of the loop
    workers : rows computed side by side
    law : friction law of the compensator
    """
    sheet = Datasheet()
    cases = [("", 1.0, sheet)]
    for quantity, wrong in factors.items():
        right = getattr(sheet, quantity)
        cases += [(quantity, f, replace(sheet, **{quantity: f * right})) for f in wrong]

    def row(case: tuple[str, float, Datasheet]) -> dict[str, object]:
        quantity, factor, assumed = case
        value = getattr(assumed, quantity) if quantity else None
        rig = FmuRig(fmus, assumed, LOOP.T_s, law)
        return {"quantity": quantity, "factor": factor, "value": value, **_outcome(rig, feed)}

    with Threads(workers) as threads:
        return pd.DataFrame(threads.each(row, cases))


def _outcome(rig: FmuRig, feed: Feed) -> dict[str, object]:
    """Return what identification and validation give; ``error`` says what failed."""
    found: dict[str, object] = {"error": ""}
    try:
        identification = identify(rig, LOOP)
        values = {name: e.value for name, e in identification.estimates.items()}
        found |= {name: values[name] for name in FOUND}
        compensator = {name: one.value for name, one in identification.tuned.items()}
        plain = identification.loop
        judged = partial(
            validate, rig, compensator=compensator, command=VALIDATION, feed=feed, phases=PHASES
        )
        for row in _rows(judged(loop=plain), "measured"):
            name = f"{row['region']}_{row['metric']}"
            found |= {f"{name}{end}": row[f"reduction{end}"] for end in ENDS}
        loop = with_inertia(with_velocity_filter(plain, rig.datasheet, compensator["F_c"]))
        rows = _rows(judged(loop=loop, plain=plain), "true")
        least = min(rows, key=lambda row: row["reduction"])
        found |= {f"filtered{end}": least[f"reduction{end}"] for end in ENDS}
    except Fault as fault:
        found["error"] = str(fault)
    return found


def _rows(validation: Validation, velocity: str) -> list[dict[Hashable, Any]]:
    table = validation.table()
    return table[table["velocity"] == velocity].to_dict("records")
