"""The reproduction, on a terminal."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import pandas as pd

from stickslip.catalog.parameters import HIGH, LOW
from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.validation import PHASES
from stickslip.papers.lugre.loop_tuning import LoopTuning, spread
from stickslip.papers.lugre.published import PAPER_COST, PublishedStudy
from stickslip.papers.lugre.steps import FILTERED, REDUCTION_WITH_FILTER
from stickslip.presentation.quantity import size_or_dash


def print_table4(table: pd.DataFrame) -> None:
    """Print Table 4, and beside it the default with a velocity filter where that was tried."""
    filtered, room = FILTERED in table, " " * 14 * (f"with{LOW}" in table)
    print(
        "velocity errors in mm/s; loop, ramps and windows were calibrated so that the simulated\n"
        "drive of Table 2, measured, comes near the real stage without compensation"
        + f"\nmedian of runs from {len(PHASES)} phases of an encoder step, and range" * bool(room)
        + f"\n                         simulated drive{room}              real stage (paper)"
        + "       simulated, velocity filter" * filtered
        + f"\nvelocity region  metric  without    with{room} reduction    without    with reduction"
        + f"          with{room} reduction" * filtered
    )
    for row in table.to_dict("records"):
        print(
            f"{row['velocity']:8} {row['region']:7} {row['metric']:6}"
            f" {row['without']:8.3f} {_ranged(row, 'with')} {100 * row['reduction']:7.1f} %"
            f"   {row['paper_without']:8.2f} {row['paper_with']:7.2f}"
            f" {100 * row['paper_reduction']:7.0f} %"
            + (
                f"       {_ranged(row, FILTERED)} {100 * row[REDUCTION_WITH_FILTER]:7.1f} %"
                if filtered
                else ""
            )
        )


def _ranged(row: Mapping[Hashable, float], name: str, width: int = 7) -> str:
    """Return the median of a row and, where it has one, its range."""
    ends = [f"{row[end]:.3f}" for end in (f"{name}{LOW}", f"{name}{HIGH}") if end in row]
    spread = f" {'(' + '-'.join(ends) + ')':13}" if ends else ""
    return size_or_dash(row[name], f"{width}.3f") + spread


def print_loops(loops: LoopTuning) -> None:
    """Print what each step brings, relative to a PI controller tuned without a model."""
    print("\nerror relative to tuned_pi, median [range] over friction and seeds")
    names = [motion.name for motion in MOTIONS]
    print(f"{'stage':14}" + "".join(f"{name:>20}" for name in names) + f"{'Ms':>6}")
    for stage, row in loops.summary().iterrows():
        cells = "".join(f"{spread(*row[name]):>20}" for name in names)
        print(f"{stage:14}{cells}{row['Ms'].iloc[0]:6.2f}")
    print(loops.sentence)


def print_published(study: PublishedStudy) -> None:
    """Print what each method makes of the coarse starts."""
    names = [motion.name.replace(" ", "_") for motion in MOTIONS]
    print(
        "from coarse starts, median over seeds and encoder phases: cost in m2/s2, then the RMS\n"
        f"error of the true velocity relative to that without compensation; there the cost is\n"
        f"{study.cost_without:.3g}, and {PAPER_COST:.2g} at the end on the real stage (paper)"
    )
    heads = "".join(f"{name:>18}" for name in names)
    print(f"{'method':16}{'seeds':>6}{'runs':>6}{'cost':>10}{heads}")
    for row in study.panel().to_dict("records"):
        shares = "".join(f"{row[name]:18.3g}" for name in names)
        print(f"{row['method']:16}{row['seeds']:6}{row['runs']:6}{row['cost']:10.2g}{shares}")
