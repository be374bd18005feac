"""What was learned of a log, on a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from typing import TextIO

import numpy as np

from stickslip.evaluation.tracking import TRACKING_FIGURES, Tracking
from stickslip.identification.estimation import Estimation
from stickslip.presentation.quantity import size_or_dash
from stickslip.studies.learn import tables
from stickslip.trial.candidates import CompensatorComparison
from stickslip.trial.guards import Benefit, Hold
from stickslip.trial.observed import ObserverTrial

TRACKING = "\ntracking error relative to none, on the same simulated drives and commands:"
WIDTHS = (9, 9, 9, 13)


def print_laws(estimation: Estimation) -> None:
    """Print the error of each law that was tried where it was not fitted."""
    print("\nforce error where the law was not fitted")
    print(tables.laws(estimation).text())
    if estimation.choice:
        print(f"law: {estimation.choice.reason}")
    print()


def print_benefit(benefit: Benefit, file: TextIO | None = None) -> None:
    """Print a row for each drive and a column for each command."""
    share = "" if benefit.share == 1.0 else f" at {benefit.share:g} of its force"
    for figure, shown in benefit.tables().items():
        factor, unit = benefit.shown(shown[0])
        what = "tracking" if len(shown) == len(benefit.rows) else figure
        print(
            f"\nRMS {what} error of simulated drives [{unit}], "
            f"without -> with the compensator{share}:",
            file=file,
        )
        commands = list(dict.fromkeys(row.command for row in shown))
        print(f"{'simulated drive':40}" + "".join(f"{name:>18}" for name in commands), file=file)
        for drive, rows in groupby(shown, key=lambda row: row.drive):
            cells = (
                f"{size_or_dash(factor * row.without)} -> {size_or_dash(factor * row.compensated)}"
                for row in rows
            )
            print(f"{drive:40}" + "".join(f"  {cell:>16}" for cell in cells), file=file)


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


def print_parts(observed: ObserverTrial) -> None:
    """Print what feedforward, disturbance observer and both leave of the error of none."""
    if observed.designed is None:
        print(f"\n{observed.reason}")
        return
    print(TRACKING, tables.parts(observed).text(), sep="\n")
    designed = observed.designed
    print(
        f"peak sensitivity {designed.sensitivity:.3g} with the observer, {designed.without:.3g} "
        f"without; recommended: {observed.recommended or 'none of them'}"
    )


def print_compared(compared: CompensatorComparison) -> None:
    """Print what each compensator leaves of the error of none, and which one is chosen."""
    print(TRACKING, tables.compensators(compared).text(), sep="\n")
    print(compared.sentence)


def print_tracking(tracking: Tracking, *, rotary: bool = False) -> None:
    """Print RMS and maximum of the tracking errors, measured and simulated."""
    print(
        f"\ntracking error on {tracking.command}, in the loop of {tracking.loop}:\n"
        "                      measured             simulated drive\n"
        "                       the log  without     with  no friction  reduction"
    )
    errors = [tracking.measured, *tracking.errors().values()]
    for key in TRACKING_FIGURES:
        factor, unit, title = _tracking_figure(key, rotary=rotary)
        cells = [f"{factor * error.items()[key]:.3g}" if error else "-" for error in errors]
        shown = "".join(f"{cell:>{width}}" for cell, width in zip(cells, WIDTHS, strict=True))
        print(f"{title:13}{unit:8}{shown} {100.0 * tracking.reduction(key):8.1f} %")


def _tracking_figure(key: str, *, rotary: bool) -> tuple[float, str, str]:
    """Return factor, unit and title of a figure of tracking errors."""
    length, (what, size) = "rad" if rotary else "m", key.split("_")
    title = f"{what} {size.upper() if size == 'rms' else size}"
    if what == "velocity":
        return 1e3, f"m{length}/s", title
    return 1e6, f"u{length}", title
