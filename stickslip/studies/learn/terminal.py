"""What was learned of a log, on a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TextIO

import numpy as np

from stickslip.evaluation.tracking import Tracking
from stickslip.identification.estimation import Estimation
from stickslip.logs import Motion
from stickslip.studies.learn import tables
from stickslip.trial.candidates import CompensatorComparison
from stickslip.trial.guards import Benefit, Hold


def print_laws(estimation: Estimation) -> None:
    """Print the error of each law that was tried where it was not fitted."""
    print("\nforce error where the law was not fitted")
    print(tables.laws(estimation).text())
    if estimation.choice:
        print(f"law: {estimation.choice.reason}")
    print()


def print_benefit(benefit: Benefit, name: str, file: TextIO | None = None) -> None:
    """Print a row for each level of friction and a column for each motion."""
    share = "" if benefit.share == 1.0 else f" at {benefit.share:g} of its force"
    for figure, table in tables.errors(benefit):
        print(
            f"\nRMS error of {figure} with {name}{share} over that without compensation, median of"
            f" simulated drives (where that of the true one is expected):\n{table.text()}",
            file=file,
        )


def print_holds(holds: Mapping[str, Hold]) -> None:
    """Print how a cascade holds its position without and with each compensation."""
    print("\nat rest, on the worst simulated drive:")
    for name, hold in holds.items():
        swing = f"swings by {1e6 * hold.swing:.3g} {hold.unit}"
        if not np.isfinite(hold.swing):
            swing = "runs away"
        print(
            f"{name:24} {swing}, {hold.reversals} reversals in {hold.duration:.3g} s; {hold.drive}"
        )


def print_compared(compared: CompensatorComparison) -> None:
    """Print what each compensator leaves of the error of none, and which one is chosen."""
    print("\ntracking error relative to none, on the same simulated drives and motions:")
    print(tables.compensators(compared).text(), compared.sentence, sep="\n")


def print_tracking(tracking: Tracking, motion: Motion) -> None:
    """Print RMS and maximum of the tracking errors, measured and simulated."""
    print(f"\ntracking error on {tracking.command}, in the loop of {tracking.loop}:")
    print(tables.tracking(tracking, motion).text())
