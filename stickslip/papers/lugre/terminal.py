"""The reproduction, on a terminal."""

from __future__ import annotations

import pandas as pd

from stickslip.catalog.parameters import LOW
from stickslip.evaluation.validation import PHASES
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.loop_tuning import LoopTuning
from stickslip.papers.lugre.published import PAPER_COST, PublishedStudy


def print_table4(table: pd.DataFrame) -> None:
    """Print Table 4, and beside it the default with a velocity filter where that was tried."""
    print(
        "velocity errors in mm/s; loop, ramps and windows were calibrated so that the simulated\n"
        "drive of Table 2, measured, comes near the real stage (paper) without compensation"
        + f"\nmedian of runs from {len(PHASES)} phases of an encoder step, and range"
        * (f"with{LOW}" in table)
    )
    print(tables.table4(table).text())


def print_loops(loops: LoopTuning) -> None:
    """Print what each step brings, relative to a PI controller tuned without a model."""
    print("\nerror relative to tuned_pi, median [range] over friction and seeds")
    print(tables.stages(loops).text(), loops.sentence, sep="\n")


def print_published(study: PublishedStudy) -> None:
    """Print what each method makes of the coarse starts."""
    print(
        "from coarse starts, median over seeds and encoder phases: cost in m2/s2, then the RMS\n"
        f"error of the true velocity relative to that without compensation; there the cost is\n"
        f"{study.cost_without:.3g}, and {PAPER_COST:.2g} at the end on the real stage (paper)"
    )
    print(tables.panel(study).text())
