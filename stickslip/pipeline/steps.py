"""What each step brings: one drive, controlled in every way that a reproduction knows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress

import pandas as pd

from stickslip.evaluation.comparison import Entry
from stickslip.evaluation.motion_study import IDENTIFIED, LEARNED, UNCOMPENSATED
from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.validation import reduction
from stickslip.identification.stages import Identification
from stickslip.pipeline.learned import Learned
from stickslip.servo.axis import ControlError
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.tuning.published import Published

TRAPEZOID = MOTIONS[0]
FILTERED = "with_filter"
"""The default with a velocity filter and feedforward of inertia, which the paper does not have."""

REDUCTION_WITH_FILTER = f"reduction_{FILTERED}"

STEPS = {
    UNCOMPENSATED: "None",
    "tuned_pi": "Tuned PI alone",
    IDENTIFIED: "Identified",
    "as_published": "As published",
    "coarse_default": "Default, coarse",
    LEARNED: "Default",
    FILTERED: "Default, filter",
    "one_recording": "One recording",
    "velocity_filter": "And filter",
}
"""The steps by the names of their columns, in the order in which they are shown."""


def steps(
    identification: Identification,
    learned: Learned,
    published: Published | None = None,
    coarse: Sequence[Mapping[str, float]] = (),
    recorded: Learned | None = None,
) -> dict[str, Entry]:
    """Return the steps that there are, in the order of ``STEPS``.

    Parameters
    ----------
    learned : by the default
    coarse : parameters of the default from the coarse starts of some of the published seeds
    recorded : from one recording
    """
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
    if published is not None:
        first, *others = (one.learned for one in published.seeds)
        found["as_published"] = Entry(loop, first, others)
    if coarse:
        found["coarse_default"] = Entry(loop, coarse[0], coarse[1:])
    if recorded is not None:
        plain, filtered, _ = recorded.designed
        found["one_recording"] = Entry(plain, recorded.friction)
        found["velocity_filter"] = Entry(filtered, recorded.friction)
    return {name: found[name] for name in STEPS if name in found}


def with_steps(table4: pd.DataFrame, motions: pd.DataFrame) -> pd.DataFrame:
    """Return Table 4 with a column [mm/s] for each step that it has not yet.

    Behind that of the filter stands the reduction with it, as a fraction.

    Parameters
    ----------
    motions : what ``Evaluation.table`` returns
    """
    keys = ["velocity", "region", "metric"]
    rows = motions[motions["motion"] == TRAPEZOID.name]
    more = [name for name in STEPS if name in rows and name not in (UNCOMPENSATED, LEARNED)]
    table = table4.merge(rows[[*keys, *more]], on=keys, how="left", validate="one_to_one")
    if FILTERED in table:
        reduced = reduction(table[UNCOMPENSATED], table[FILTERED])
        table.insert(list(table.columns).index(FILTERED) + 1, REDUCTION_WITH_FILTER, reduced)
    return table
