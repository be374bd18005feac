"""Section 4.2 of the paper, Table 4 step by step, and the slow motions."""

from functools import partial

import pandas as pd

from stickslip.evaluation.motions import SLOW_MOTIONS
from stickslip.evaluation.validation import Validation
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.page.curves import draw_motions, draw_steps, draw_tracking
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.papers.lugre.steps import (
    FILTERED,
    LEARNED,
    REDUCTION_WITH_FILTER,
    STEPS,
    TRAPEZOID,
    UNCOMPENSATED,
)
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import METRICS, percent, ranged
from stickslip.servo.measurement import CUTOFF
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.tuned_pi import tuned_pi


def validation_section(validation: Validation, table4: pd.DataFrame | None = None) -> Section:
    """Return the section on validation; Table 4 may have columns of the velocity filter."""
    errors = validation.table() if table4 is None else table4
    filtered, draw = FILTERED in errors, {"fig6_tracking": partial(draw_tracking, validation)}
    values = {"rows": _rows(errors), "filtered": filtered, "CUTOFF": CUTOFF}
    return section("Validation", "validation", None, draw, **values)


def _rows(frame: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return each error of the simulated drive, measured and true, and then the real stage's."""
    rows: list[tuple[str, ...]] = []
    for (region, metric), errors in frame.groupby(["region", "metric"], sort=False):
        name = f"Motion {region}, {METRICS[str(metric)]}"
        for row in errors.to_dict("records"):
            label = f"simulated drive, {row['velocity']}"
            numbers = ranged(row, "without"), ranged(row, "with"), ranged(row, "reduction", percent)
            rows.append((name, label, *numbers))
            if FILTERED in row:
                reduced = ranged(row, REDUCTION_WITH_FILTER, percent)
                numbers = numbers[0], ranged(row, FILTERED), reduced
                rows.append((name, f"{label}, velocity filter", *numbers))
        paper = f"{row['paper_without']:.2f}", f"{row['paper_with']:.2f}"
        rows.append((name, "real stage (paper)", *paper, percent(row["paper_reduction"], 0)))
    return rows


def steps_section(reproduction: Reproduction) -> Section | None:
    """Return the section, None where the steps were not compared."""
    if reproduction.motions is None:
        return None
    draw, loop = {"steps": partial(draw_steps, reproduction)}, reproduction.identification.loop
    loops = {"own": loop, "tuned": tuned_pi(loop), "peak": peak_sensitivity(loop)}
    return section("Comparison of the steps", "steps", reproduction, draw, **loops)


def motions_section(reproduction: Reproduction) -> Section | None:
    """Return the section on the other motions, None where they were not run."""
    if reproduction.motions is None:
        return None
    frame = reproduction.motions.table()
    slow = frame[frame["motion"] != TRAPEZOID.name]
    left = slow[LEARNED] / slow[UNCOMPENSATED]
    worse = [
        f"{tables.error_name(row)}, {row['velocity']} ({percent(share, 0)})"
        for row, share in zip(slow.to_dict("records"), left, strict=True)
        if share > 1.0
    ]
    return section(
        "Slow reversals, creep and micrometre moves",
        "motions",
        reproduction,
        {"motions": partial(draw_motions, reproduction)},
        slow={motion: tables.motions(own) for motion, own in slow.groupby("motion", sort=False)},
        learned=STEPS[LEARNED],
        worse=worse,
        half=int((left > 0.5).sum()),
        total=len(slow),
        SLOW_MOTIONS=SLOW_MOTIONS,
    )
