"""What each step brings: one drive, controlled in every way that a reproduction knows."""

from contextlib import suppress

import pandas as pd

from stickslip.catalog.parameters import HIGH, LOW
from stickslip.evaluation.comparison import Entry, Evaluation
from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.validation import ranges_last, reduction, summary
from stickslip.identification.stages import Identification
from stickslip.servo.axis import ControlError, Datasheet
from stickslip.servo.tuned_pi import tuned_pi, with_inertia, with_velocity_filter
from stickslip.studies.learn.learned import Learned

TRAPEZOID = MOTIONS[0]
UNCOMPENSATED, IDENTIFIED, LEARNED = "without", "identified", "learned"
"""Names of entries: no compensation, the identified parameters, the learned ones."""
FILTERED = "with_filter"
"""The default with a velocity filter and feedforward of inertia, which the paper does not have."""

REDUCTION_WITH_FILTER = f"reduction_{FILTERED}"

STEPS = {
    UNCOMPENSATED: "None",
    "tuned_pi": "Tuned PI alone",
    IDENTIFIED: "Identified",
    LEARNED: "Default",
    FILTERED: "Default, filter",
}
"""The steps by the names of their columns, in the order in which they are shown."""


def steps(identification: Identification, learned: Learned) -> dict[str, Entry]:
    """Return the steps that there are, in the order of ``STEPS``."""
    loop = identification.loop
    identified = {name: one.value for name, one in identification.tuned.items()}
    found = {
        UNCOMPENSATED: Entry(loop),
        "tuned_pi": Entry(tuned_pi(loop)),
        IDENTIFIED: Entry(loop, identified),
        LEARNED: Entry(loop, learned.friction),
    }
    with suppress(ControlError):
        filtered = with_velocity_filter(loop, Datasheet(), learned.friction["F_c"])
        found[FILTERED] = Entry(with_inertia(filtered), learned.friction)
    return found


def by_step(table4: pd.DataFrame) -> pd.DataFrame:
    """Return Table 4 with the names of the steps: ``LEARNED`` for its column ``with``."""
    ends = ("", LOW, HIGH)
    return table4.rename(columns={f"with{end}": f"{LEARNED}{end}" for end in ends})


def with_steps(table4: pd.DataFrame, evaluation: Evaluation) -> pd.DataFrame:
    """Return Table 4 with a column [mm/s] for each step that it has not yet, with ranges."""
    names = [n for n in STEPS if n in evaluation.errors and n not in (UNCOMPENSATED, LEARNED)]
    errors = {n: pd.DataFrame(t.loc[TRAPEZOID.name]) for n, t in evaluation.errors.items()}
    found = {n: errors[n] for n in names}
    if FILTERED in found:
        found[REDUCTION_WITH_FILTER] = reduction(errors[UNCOMPENSATED], errors[FILTERED])
    keys = ["velocity", "region", "metric"]
    rows = summary(found).reset_index().drop(columns="unit")
    table = table4.merge(rows, on=keys, how="left", validate="one_to_one")
    if FILTERED in found:
        table[REDUCTION_WITH_FILTER] = reduction(table[UNCOMPENSATED], table[FILTERED])
    return ranges_last(table)
