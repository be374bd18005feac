"""Tables of results, on a terminal and as files."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from itertools import groupby
from pathlib import Path
from typing import TextIO

import numpy as np
import pandas as pd

from stickslip.catalog.parameters import unit_of
from stickslip.evaluation.compared_logs import LogComparison, sentences
from stickslip.evaluation.guards import Benefit, Hold
from stickslip.evaluation.log_prediction import LogPrediction
from stickslip.evaluation.log_verdict import SIGNALS, verdict
from stickslip.evaluation.motion_study import (
    IDENTIFIED,
    LEARNED,
    UNCOMPENSATED,
    MotionStudy,
    limits,
)
from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.scatter import HIGH, LOW, PHASES
from stickslip.evaluation.tracking import FEEDFORWARD, NONE, TRACKING_FIGURES, Tracking
from stickslip.fmi.files import atomic_write
from stickslip.identification.estimation import Estimation
from stickslip.identification.selection import law_table
from stickslip.pipeline.candidates import Compared
from stickslip.pipeline.loop_tuning import LoopTuning, spread
from stickslip.pipeline.observed import Observed
from stickslip.pipeline.steps import FILTERED, REDUCTION_WITH_FILTER, TRAPEZOID
from stickslip.results.folder import staged
from stickslip.tuning.published import PAPER_COST, PublishedStudy

TRACKING = "\ntracking error relative to none, on the same simulated drives and commands:"
SHARES = f"{'fitted drive':>14}{'mean':>8}{'worst':>8}"


def write_files(out: Path | None, command: Mapping[str, object], files: Mapping[str, str]) -> None:
    """Write texts by file name into a folder of results, if there is one, and print their paths."""
    if out is None:
        return
    with staged(out, command) as staging:
        for name, text in files.items():
            atomic_write(staging / name, text)
    print(*(out / name for name in files), sep="\n")


def _ranged(row: Mapping[Hashable, float], name: str, width: int = 7) -> str:
    """Return the median of a row and, where it has one, its range."""
    ends = [f"{row[end]:.3f}" for end in (f"{name}{LOW}", f"{name}{HIGH}") if end in row]
    spread = f" {'(' + '-'.join(ends) + ')':13}" if ends else ""
    return _size(row[name], f"{width}.3f") + spread


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


def print_motions(study: MotionStudy) -> None:
    """Print the RMS errors of the true velocity in slow motions, and what they say."""
    table = study.evaluation.table()
    slow = table[table["motion"] != TRAPEZOID.name]
    shown = slow[(slow["metric"] == "E_rms") & (slow["velocity"] == "true")]
    names = (UNCOMPENSATED, IDENTIFIED, LEARNED)
    print("\nslow motions, E_rms of the true velocity in mm/s, median and range")
    print(f"{'motion':28}" + "".join(f"{name:>12}{'':14}" for name in names))
    for row in shown.to_dict("records"):
        sizes = "".join(_ranged(row, name, 12) for name in names)
        print(f"{row['motion'] + ', ' + row['region']:28}{sizes}")
    print(limits(slow, {name: str(name) for name in slow["metric"]}))


def print_loops(loops: LoopTuning) -> None:
    """Print what each step brings, relative to a PI controller tuned without a model."""
    print("\nerror relative to tuned_pi, median [range] over friction and seeds")
    names = [motion.name for motion in MOTIONS]
    print(f"{'stage':14}" + "".join(f"{name:>20}" for name in names) + f"{'Ms':>6}")
    for stage, row in loops.summary().iterrows():
        cells = "".join(f"{spread(*row[name]):>20}" for name in names)
        print(f"{stage:14}{cells}{row['Ms'].iloc[0]:6.2f}")
    print(loops.sentence)


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
                f"{_size(factor * row.without)} -> {_size(factor * row.compensated)}"
                for row in rows
            )
            print(f"{drive:40}" + "".join(f"  {cell:>16}" for cell in cells), file=file)


def _size(value: float, spec: str = ".3g") -> str:
    """Return a number, or a dash of the same width where a run has failed."""
    return f"{value:{spec}}" if np.isfinite(value) else f"{'-':>{spec.partition('.')[0] or 0}}"


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
    return "".join(_size(one[name], spec) for name, spec in widths.items())


def print_laws(estimation: Estimation) -> None:
    """Print the error of each law that was tried where it was not fitted."""
    unit = unit_of("F_c", rotary=estimation.recording.rotary)
    print(f"\nforce error where the law was not fitted [{unit}]        noise and steps explain")
    for row in law_table(estimation.predictions).to_dict("records"):
        error = f"{row['held_out_error']:9.3g} {100.0 * row['relative']:8.3g} %"
        print(f"{row['law']:18}{error} {row['explained']:20.3g}")
    if estimation.choice:
        print(f"law: {estimation.choice.reason}")
    print()


WIDTHS = (9, 9, 9, 13)


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


def print_prediction(found: LogPrediction, values: Mapping[str, float]) -> None:
    """Print the verdict on another log of a learned drive, and its errors."""
    first, *reasons = verdict(found, values)
    print(f"\nverdict: {first}")
    print(*(f"  {reason}" for reason in reasons), sep="\n")
    print("\nrecorded less predicted, RMS in SI units")
    print(f"{'':24} {'error':>10} {'noise':>10} {'intervals':>10} {'relative':>10} {'ratio':>7}")
    for name, one in found.signals.items():
        sizes = "".join(f"{x:11.3g}" for x in (one.error, one.noise, one.intervals))
        print(f"{SIGNALS[name]:24}{sizes} {100.0 * one.relative:8.3g} % {one.ratio:7.2g}")


def print_comparison(found: LogComparison, *, rotary: bool = False) -> None:
    """Print tracking errors without and with the compensator, measured and simulated."""
    print(*sentences(found), sep="\n")
    n = int(found.part.max()) + 1
    print(f"\n{'':24} {'':8}  without     with  reduction   95 % interval, {n} parts")
    for kind, one in (("measured", found.measured), ("simulated", found.simulated)):
        if one is None:
            continue
        for key, reduction in one.reductions.items():
            factor, unit, title = _tracking_figure(key, rotary=rotary)
            sizes = (one.errors[name].items()[key] for name in (NONE, FEEDFORWARD))
            cells = "".join(f"{factor * size:9.3g}" for size in sizes)
            ends = f"[{100.0 * reduction.low:.3g} %, {100.0 * reduction.high:.3g} %]"
            print(f"{kind:10} {title:13} {unit:8}{cells} {100.0 * reduction.value:8.1f} %   {ends}")


def _tracking_figure(key: str, *, rotary: bool) -> tuple[float, str, str]:
    """Return factor, unit and title of a figure of tracking errors."""
    length, (what, size) = "rad" if rotary else "m", key.split("_")
    title = f"{what} {size.upper() if size == 'rms' else size}"
    if what == "velocity":
        return 1e3, f"m{length}/s", title
    return 1e6, f"u{length}", title


def print_published(study: PublishedStudy) -> None:
    """Print what each method makes of the coarse starts."""
    names = [motion.name.replace(" ", "_") for motion in MOTIONS]
    print(
        "from coarse starts, median over seeds and encoder phases: cost in m2/s2, then the RMS\n"
        f"error of the true velocity relative to that without compensation; there the cost is\n"
        f"{study.cost_without:.3g}, and {PAPER_COST:.2g} at the end on the real stage (paper); "
        "worse: seeds that\ntrack worse than from their start, on the trapezoid and in slow motion"
    )
    heads = "".join(f"{name:>18}" for name in names)
    print(f"{'method':16}{'seeds':>6}{'runs':>6}{'cost':>10}{heads}  worse")
    for row in study.panel().to_dict("records"):
        shares = "".join(f"{row[name]:18.3g}" for name in names)
        print(
            f"{row['method']:16}{row['seeds']:6}{row['runs']:6}{row['cost']:10.2g}{shares}"
            f"{row['worse']:5} {row['worse_slow']}"
        )
