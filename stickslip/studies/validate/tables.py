"""The tables of a learned drive against other logs, as terminal, page and files have them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.evaluation.tracking import FEEDFORWARD, NONE
from stickslip.logs import Motion
from stickslip.models.export.units import motion_unit
from stickslip.presentation.quantity import number, percentage
from stickslip.presentation.scale import (
    WORDS,
    Scale,
    force_scale,
    position_scale,
    velocity_scale,
)
from stickslip.presentation.table import Column, Row, Table
from stickslip.studies.validate.compared_logs import LogComparison, TrackingComparison
from stickslip.studies.validate.log_prediction import LogPrediction
from stickslip.studies.validate.log_verdict import SIGNALS

TITLES = {
    "force": "{0}, inverse model",
    "position": "{1}, loop simulated",
    "velocity": "Velocity, loop simulated",
    "closed_loop_force": "{0}, loop simulated",
}


def signal_title(name: str, motion: Motion) -> str:
    """Return what a page calls a signal."""
    place, push = (word.capitalize() for word in WORDS[motion])
    return TITLES[name].format(push, place)


def signal_scale(motion: Motion, name: str, size: float) -> Scale:
    """Return the unit of a signal by the first word of its name."""
    kinds = {"position": position_scale, "velocity": velocity_scale}
    return kinds.get(name.split("_")[0], force_scale)(motion, np.array([size]))


def signals(found: LogPrediction) -> Table:
    """Return the errors of the predicted signals, RMS."""
    motion = found.recording.motion

    def scale(row: Row) -> Scale:
        return signal_scale(motion, row["signal"], row["error"])

    def size(name: str, title: str) -> Column:
        def scaled(row: Row) -> str:
            return number(scale(row).factor * row[name], 3)

        return Column(name, text=".3g", title=title, head=title.capitalize(), cell=scaled)

    columns = (
        Column(
            "signal",
            text=lambda row: SIGNALS[row["signal"]],
            title="",
            head="Signal",
            cell=lambda row: signal_title(row["signal"], motion),
        ),
        Column("unit", head="Unit", cell=lambda row: scale(row).unit, stored=False),
        size("error", "error"),
        Column(
            "relative",
            text=lambda row: f"{100.0 * row['relative']:.3g} %",
            title="relative",
            head="Relative",
            cell=lambda row: percentage(row["relative"]),
        ),
        size("noise", "noise"),
        size("intervals", "intervals"),
        Column("ratio", text=".2g", title="ratio", head="Ratio", digits=2),
    )
    rows = [
        {"signal": name, "unit": "", **vars(one), "ratio": one.ratio}
        for name, one in found.signals.items()
    ]
    return Table(columns, rows)


def kinds(found: LogComparison) -> Iterator[tuple[str, TrackingComparison]]:
    """Yield what was measured, and what was simulated where that could be done."""
    yield "measured", found.measured
    if found.simulated:
        yield "simulated", found.simulated


def tracking(found: LogComparison, motion: Motion) -> Table:
    """Return tracking errors without and with the compensator, and the reduction."""

    def scale(row: Row) -> Scale:
        what = velocity_scale if row["error"].startswith("velocity") else position_scale
        return what(motion, np.array([row["without"]]))

    def title(row: Row) -> str:
        what, size = row["error"].split("_")
        what = what if what == "velocity" else WORDS[motion][0]
        return f"{row['kind']} {what}, {'RMS' if size == 'rms' else 'maximum'}"

    def size(name: str) -> Column:
        def scaled(row: Row) -> str:
            return number(scale(row).factor * row[name], 3)

        return Column(name, text=scaled, title=name, head=name.capitalize(), cell=scaled)

    def ends(row: Row) -> str:
        return f"{percentage(row['low'])} … {percentage(row['high'])}"

    columns = (
        Column("kind"),
        Column("error", text=title, head="", cell=lambda row: title(row).capitalize()),
        Column("unit", text=lambda row: scale(row).unit, head="", cell=lambda row: scale(row).unit),
        size("without"),
        size("with"),
        Column(
            "reduction",
            text=lambda row: f"{100.0 * row['reduction']:.1f} %",
            title="reduction",
            head="Reduction",
            cell=lambda row: percentage(row["reduction"]),
        ),
        Column("low", text=ends, title="95 % interval", head="95 % interval", cell=ends),
        Column("high"),
    )
    rows = [
        {
            "kind": kind,
            "error": key,
            "unit": motion_unit(
                "m/s" if key.startswith("velocity") else "m", rotary=motion == "rotary"
            ),
            "without": one.errors[NONE].items()[key],
            "with": one.errors[FEEDFORWARD].items()[key],
            "reduction": reduction.value,
            "low": reduction.low,
            "high": reduction.high,
        }
        for kind, one in kinds(found)
        for key, reduction in one.reductions.items()
    ]
    return Table(columns, rows)
