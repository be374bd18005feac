"""What was learned of a log, on a terminal."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from itertools import groupby
from typing import TextIO

import numpy as np

from stickslip.catalog.parameters import unit_of
from stickslip.evaluation.tracking import TRACKING_FIGURES, Tracking
from stickslip.identification.estimation import Estimation
from stickslip.identification.selection import law_table
from stickslip.presentation.quantity import size_or_dash
from stickslip.trial.candidates import Compared
from stickslip.trial.guards import Benefit, Hold
from stickslip.trial.observed import Observed

TRACKING = "\ntracking error relative to none, on the same simulated drives and commands:"
SHARES = f"{'fitted drive':>14}{'mean':>8}{'worst':>8}"
WIDTHS = (9, 9, 9, 13)


def print_laws(estimation: Estimation) -> None:
    """Print the error of each law that was tried where it was not fitted."""
    unit = unit_of("F_c", rotary=estimation.recording.rotary)
    print(f"\nforce error where the law was not fitted [{unit}]        noise and steps explain")
    for row in law_table(estimation.held_out.predictions).to_dict("records"):
        error = f"{row['held_out_error']:9.3g} {100.0 * row['relative']:8.3g} %"
        print(f"{row['law']:18}{error} {row['explained']:20.3g}")
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


def print_parts(observed: Observed) -> None:
    """Print what feedforward, disturbance observer and both leave of the error of none."""
    if observed.designed is None:
        print(f"\n{observed.reason}")
        return
    print(TRACKING, f"{'compensation':24}{SHARES}", sep="\n")
    for one in observed.summary().to_dict("records"):
        note = "" if one["acceptable"] else "  worse than none"
        print(f"{one['part']:24}{_ratios(one)}{note}")
    designed = observed.designed
    print(
        f"peak sensitivity {designed.sensitivity:.3g} with the observer, {designed.without:.3g} "
        f"without; recommended: {observed.recommended or 'none of them'}"
    )


def print_compared(compared: Compared) -> None:
    """Print what each compensator leaves of the error of none, and which one is chosen."""
    print(TRACKING, f"{'compensator':24}{SHARES}{'Ms':>8}", sep="\n")
    for one in compared.table().to_dict("records"):
        note = "" if one["acceptable"] else "  worse than none"
        print(f"{one['compensator']:24}{_ratios(one)}{one['Ms']:8.3g}{note}")
    print(compared.sentence)


def _ratios(one: Mapping[Hashable, float]) -> str:
    """Return the ratios of the errors to those of none, of a row of a summary."""
    widths = {"fitted": "14.3g", "mean": "8.3g", "worst": "8.4g"}
    return "".join(size_or_dash(one[name], spec) for name, spec in widths.items())


def print_tracking(tracking: Tracking, *, rotary: bool = False) -> None:
    """Print RMS and maximum of the tracking errors, measured and simulated."""
    print(
        f"\ntracking error on {tracking.command}, in the loop of {tracking.loop}:\n"
        "                      measured             simulated drive\n"
        "                       the log  without     with  no friction  reduction"
    )
    errors = [tracking.measured, *tracking.errors().values()]
    for key in TRACKING_FIGURES:
        factor, unit, title = tracking_figure(key, rotary=rotary)
        cells = [f"{factor * error.items()[key]:.3g}" if error else "-" for error in errors]
        shown = "".join(f"{cell:>{width}}" for cell, width in zip(cells, WIDTHS, strict=True))
        print(f"{title:13}{unit:8}{shown} {100.0 * tracking.reduction(key):8.1f} %")


def tracking_figure(key: str, *, rotary: bool) -> tuple[float, str, str]:
    """Return factor, unit and title of a figure of tracking errors."""
    length, (what, size) = "rad" if rotary else "m", key.split("_")
    title = f"{what} {size.upper() if size == 'rms' else size}"
    if what == "velocity":
        return 1e3, f"m{length}/s", title
    return 1e6, f"u{length}", title
