"""The tables of a learned drive against other logs, as terminal, page and files have them."""

from collections.abc import Iterator
from dataclasses import replace

from stickslip.catalog.parameters import Values
from stickslip.evaluation.tracking import FEEDFORWARD, NONE
from stickslip.logs import Motion
from stickslip.models.export.units import motion_unit
from stickslip.presentation.quantity import interval, number, percentage, unit
from stickslip.presentation.scale import WORDS, Scale, force_scale, position_scale, velocity_scale
from stickslip.presentation.table import Column, Row, Table, scaled, share, units
from stickslip.studies.learn.tables import error_title
from stickslip.studies.validate.compared_logs import LogComparison, TrackingComparison
from stickslip.studies.validate.log_prediction import LogPrediction
from stickslip.studies.validate.log_verdict import SIGNALS, change_scale
from stickslip.studies.validate.log_verdict import WORDS as CHANGES


def signal_title(name: str, motion: Motion) -> str:
    """Return what a page calls a signal."""
    place, push = WORDS[motion]
    return SIGNALS[name].replace("position", place).replace("force", push).capitalize()


def signal_scale(motion: Motion, name: str, size: float) -> Scale:
    """Return the unit of a signal by the first word of its name."""
    kinds = {"position": position_scale, "velocity": velocity_scale}
    return kinds.get(name.split("_")[0], force_scale)(motion, size)


def signals(found: LogPrediction) -> Table:
    """Return the errors of the predicted signals, RMS."""
    motion = found.recording.motion

    def scale(row: Row) -> Scale:
        return signal_scale(motion, row["signal"], row["error"])

    def size(name: str) -> Column:
        return scaled(name, scale, name.capitalize(), ".3g")

    columns = (
        Column(
            "signal",
            lambda row: SIGNALS[row["signal"]],
            head="Signal",
            cell=lambda row: signal_title(row["signal"], motion),
        ),
        Column("unit", head="Unit", cell=lambda row: scale(row).unit, stored=False),
        size("error"),
        share("relative", "Relative"),
        size("noise"),
        size("intervals"),
        Column("ratio", ".2g", "ratio", "Ratio", digits=2),
    )
    rows = [
        {"signal": name, **vars(one), "ratio": one.ratio} for name, one in found.signals.items()
    ]
    return Table(columns, rows)


def changes(found: LogPrediction, values: Values) -> Table:
    """Return what has changed since the drive was learned, with 95 % intervals."""

    def scale(row: Row) -> Scale:
        return change_scale(row["parameter"], found, values)

    def ends(row: Row) -> str:
        return interval(*(scale(row).factor * row[end] for end in ("low", "high")))

    columns = (
        Column("parameter", head="", cell=lambda row: CHANGES[row["parameter"]].capitalize()),
        scaled("value", scale, "Change"),
        Column("low", head="95 % interval", cell=ends),
        Column("high"),
        Column("unit", head="Unit", cell=lambda row: unit(scale(row).unit), stored=False),
    )
    rows = [{"parameter": name, **vars(change)} for name, change in found.changes.items()]
    return Table(columns, rows)


def spans(found: LogPrediction) -> Table:
    """Return the errors in each part of a log."""
    motion = found.recording.motion
    titles = {
        "force_bias": "Force, mean error in the direction of motion",
        "force_error": "Force, RMS error",
        "position_error": f"{WORDS[motion][0].capitalize()}, RMS error",
    }

    def size(name: str) -> Column:
        scale = signal_scale(motion, name, float(found.spans[name].abs().max()))

        return scaled(name, lambda _: scale, f"{titles[name]} [{scale.unit}]")

    def time(row: Row) -> str:
        return f"{number(row['begin'], 3)} to {number(row['end'], 3)}"

    columns = (
        Column("begin", head="Time [s]", cell=time, words=True),
        Column("end"),
        *map(size, found.spans.columns[2:]),
    )
    return Table.of(columns, found.spans)


def kinds(found: LogComparison) -> Iterator[tuple[str, TrackingComparison]]:
    """Yield what was measured, and what was simulated where that could be done."""
    yield "measured", found.measured
    if found.simulated:
        yield "simulated", found.simulated


def tracking(found: LogComparison) -> Table:
    """Return tracking errors without and with the compensator, and the reduction."""
    motion = found.motion

    def scale(row: Row) -> Scale:
        what = velocity_scale if row["error"].startswith("velocity") else position_scale
        return what(motion, row["without"])

    def title(row: Row) -> str:
        what = error_title(row["error"], motion)
        return f"{row['kind'].capitalize()} {what[0].lower()}{what[1:]}"

    def ends(row: Row) -> str:
        return f"{percentage(row['low'])} … {percentage(row['high'])}"

    columns = (
        Column("kind"),
        Column("error", title, head=""),
        replace(units(scale), stored=True),
        scaled("without", scale, "Without"),
        scaled("with", scale, "With"),
        share("reduction", "Reduction"),
        Column("low", ends, "95 % interval", "95 % interval"),
        Column("high"),
    )
    rows = [
        {
            "kind": kind,
            "error": key,
            "unit": motion_unit(
                "m/s" if key.startswith("velocity") else "m", rotary=motion == "rotary"
            ),
            "without": getattr(one.errors[NONE], key),
            "with": getattr(one.errors[FEEDFORWARD], key),
            "reduction": reduction.value,
            "low": reduction.low,
            "high": reduction.high,
        }
        for kind, one in kinds(found)
        for key, reduction in one.reductions.items()
    ]
    return Table(columns, rows)
