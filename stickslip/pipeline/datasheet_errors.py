"""What is known before any experiment, and what comes out when it is wrong.

Identification and learning see a drive through its measurements, but not only: the data sheet gives
them a few numbers. Each is varied here with the drive left as it is: identification, the paper's
loop with the identified compensator, and the same with a velocity filter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pandas as pd

from stickslip.evaluation.validation import Validation, run_command, validate
from stickslip.fmi.errors import Fault
from stickslip.fmi.process import Threads
from stickslip.identification.stages import identify
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.datasheet import LOOP, Datasheet
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.paper_commands import VALIDATION
from stickslip.servo.systems import Feed

FACTORS: Mapping[str, tuple[float, ...]] = {
    "mass": (0.7, 1.3),
    "peak_force": (0.5,),
    "tau_i": (0.5, 3.0),
    "encoder_step": (0.5, 2.0),
    "force_noise": (0.2, 5.0),
}
"""How wrong each number of ``setup.Datasheet`` is taken to be."""
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
    loop with velocity filter and feedforward of inertia; ``error``, what failed. What was not
    reached is missing. Values are in SI units, reductions are fractions.

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
        validation = validate(rig, plain, compensator, VALIDATION, feed)
        for (region, metric), reduction in _reductions(validation, "measured").items():
            found[f"{region}_{metric}"] = reduction
        loop = with_inertia(with_velocity_filter(plain, rig.datasheet, compensator["F_c"]))
        filtered = run_command(rig, loop, compensator, validation.without.v_cmd, feed)
        validation = replace(validation, compensated=filtered)
        found["filtered"] = min(_reductions(validation, "true").values())
    except Fault as fault:
        found["error"] = str(fault)
    return found


def _reductions(validation: Validation, velocity: str) -> dict[tuple[str, str], float]:
    table = validation.table()
    table = table[table["velocity"] == velocity]
    return {(row["region"], row["metric"]): row["reduction"] for row in table.to_dict("records")}
