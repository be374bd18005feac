"""The tables of what was learned of a log, as the terminal, the page and the files have them."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

from stickslip.catalog.parameters import unit_of
from stickslip.evaluation.tracking import (
    FEEDFORWARD,
    FRICTIONLESS,
    NONE,
    TRACKING_FIGURES,
    Tracking,
    TrackingError,
)
from stickslip.identification.estimation import Estimation
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.logs import Finding, Motion
from stickslip.models import load_model
from stickslip.presentation.markup import parts as markup
from stickslip.presentation.quantity import (
    interval,
    meaning,
    number,
    size_or_dash,
    symbol,
    unit,
    with_error,
)
from stickslip.presentation.scale import (
    WORDS,
    Scale,
    parameter_scale,
    position_scale,
    velocity_scale,
)
from stickslip.presentation.table import Column, Row, Table, scaled, share, units
from stickslip.studies.learn.predicted_logs import PredictedLog
from stickslip.trial.benefit import Benefit, MotionErrors, by_motion
from stickslip.trial.candidates import CompensatorComparison


def parameters(estimation: Estimation) -> Table:
    """Return the parameters of the drive, with 95 % intervals."""
    recording, law = estimation.recording, estimation.law

    def scale(row: Row) -> Scale:
        return parameter_scale(row["parameter"], row["value"], recording.motion)

    def shown(row: Row) -> str:
        value = scale(row).factor * row["value"]
        if row["identifiability"] == NOT_IDENTIFIABLE:
            return f"≈ {number(value, 2)}"
        return with_error(value, scale(row).factor * row["standard_error"])

    def ends(row: Row) -> str:
        return interval(scale(row).factor * row["low"], scale(row).factor * row["high"])

    columns = (
        Column("parameter", text="", head="", cell=lambda row: symbol(row["parameter"])),
        Column("meaning", head="", cell=lambda row: meaning(row["parameter"], law), stored=False),
        Column("unit", text="", head="Unit", cell=lambda row: scale(row).unit),
        Column("value", text=".6g", head="Learned", cell=shown),
        Column("standard_error"),
        Column("low", text=lambda row: f"[{row['low']:.5g},", head="95 % interval", cell=ends),
        Column("high", text=lambda row: f"{row['high']:.5g}]"),
        Column("identifiability"),
        Column(
            "sentence", text="", head="How well", cell=lambda row: markup.prose(row["sentence"])
        ),
    )
    rows = [
        {"parameter": name, "meaning": "", "unit": unit_of(name, rotary=recording.rotary)}
        | {column.name: getattr(known, column.name) for column in columns[3:]}
        for name, known in estimation.known.items()
    ]
    return Table(columns, rows)


HELD = (
    "position_force.fmu cancels it; compensators are compared on drives without it, as it is the "
    "same with each of them and with none."
)


def position_force(estimation: Estimation) -> Table:
    """Return the terms of the force of position that were found, with 95 % intervals."""
    rotary, found = estimation.recording.rotary, estimation.position_force
    block = load_model("position_force").of_motion(rotary=rotary)
    variables = {one.name: one for one in block.variables}

    def ends(row: Row) -> str:
        return interval(row["low"], row["high"])

    columns = (
        Column("parameter", text="", head=""),
        Column("meaning", head="", stored=False),
        Column("unit", lambda row: unit(row["unit"]), head="Unit"),
        Column(
            "value",
            text=".6g",
            head="Learned",
            cell=lambda row: with_error(row["value"], row["standard_error"]),
        ),
        Column("standard_error"),
        Column("low", text=lambda row: f"[{row['low']:.5g},", head="95 % interval", cell=ends),
        Column("high", text=lambda row: f"{row['high']:.5g}]"),
    )
    rows = [
        {"parameter": name, "meaning": variables[name].description, "unit": variables[name].unit}
        | vars(one)
        for name, one in (found.terms if found else {}).items()
    ]
    return Table(columns, rows)


def laws(estimation: Estimation) -> Table:
    """Return the force error of each law that was tried, where it was not fitted."""
    columns = _force_errors("held_out_error", rotary=estimation.recording.rotary)
    rows = [
        {
            "law": one.candidate.title,
            "held_out_error": one.force,
            "relative": one.relative,
            "explained": one.explained,
        }
        for one in estimation.held_out.predictions
    ]
    return Table(columns, rows)


def _force_errors(error: str, *, rotary: bool) -> tuple[Column, ...]:
    unit = unit_of("F_c", rotary=rotary)
    force = partial(Column, digits=3, unit=unit)
    return (
        Column("law", "", "law", "Friction law"),
        force(error, ".3g", f"error [{unit}]", f"Error where not fitted [{unit}]"),
        share("relative", "Of the force", unit="1"),
        force("explained", ".3g", "noise and steps explain", f"Explained [{unit}]"),
    )


def predicted_logs(logs: Iterable[PredictedLog], *, rotary: bool) -> Table:
    """Return the force error of logs that were not learned from."""
    columns = (Column("source", "", "log", "Log"), *_force_errors("error", rotary=rotary))
    return Table(columns, [vars(one) for one in logs])


RATIOS = (
    Column("share", lambda row: size_or_dash(row["share"]), "share", "Share of its force"),
    Column("fitted", ".3g", "fitted drive", "Fitted drive"),
    Column("mean", ".3g", "mean", "Mean"),
    Column("worst", ".4g", "worst motion", "Worst motion"),
)
"""Errors relative to those without compensation: of the fitted drive the geometric mean over the
motions, that over all drives, and the largest that few drives of a level of friction exceed."""


def ratios(benefit: Benefit | None) -> dict[str, float]:
    """Return the values of ``RATIOS``; 1 without compensation."""
    if benefit is None:
        return {"share": float("nan"), "fitted": 1.0, "mean": 1.0, "worst": 1.0}
    share = benefit.share if benefit.variant.has_feedforward else float("nan")
    found = share, benefit.fitted_ratio, benefit.mean_ratio, benefit.worst_ratio
    return dict(zip((column.name for column in RATIOS), found, strict=True))


def compensators(compared: CompensatorComparison) -> Table:
    """Return what each compensator that was tried leaves of the error without compensation."""
    columns = (
        Column("compensator", text="", title="compensator", head="Compensator"),
        *RATIOS,
        Column("Ms", text=".3g", title="Ms", head="$M_s$"),
        Column(
            "acceptable",
            text=lambda row: "" if row["acceptable"] else "worse than none",
            head="Worse than none",
            cell=lambda row: "" if row["acceptable"] else "yes",
        ),
    )
    rows = [
        {"compensator": row.name, "Ms": row.sensitivity, "acceptable": row.acceptable}
        | ratios(row.benefit)
        for row in compared.rows
    ]
    return Table(columns, rows)


def findings(estimation: Estimation, found: Iterable[Finding]) -> Table:
    """Return what reading and checks found and what was done about it, errors first."""
    found = [*found]
    faults = [fault for fault in estimation.faults if fault not in found]
    done = [Finding("note", remark) for remark in estimation.remarks]
    order = ("error", "warning", "note")

    def words(name: str) -> Column:
        return Column(name, head=name.capitalize(), cell=lambda row: markup.prose(row[name]))

    columns = (Column("severity", head=""), *map(words, ("what", "figure", "advice")))
    ordered = sorted([*found, *faults, *done], key=lambda finding: order.index(finding.severity))
    return Table(columns, [vars(finding) for finding in ordered])


def predicted(benefit: Benefit) -> Table:
    """Return the error with a compensator over that without, by motion and level of friction."""
    names = ("motion", "figure", "speed", "friction", "drives", "ratio", "low", "high", "decides")
    rows = []
    for one in (*benefit.motions, *by_motion(benefit.beyond)):
        row, (low, high) = one.rows[0], one.interval
        values = row.command, row.figure, row.speed, one.level, len(one.rows), one.median.ratio
        rows.append(dict(zip(names, (*values, low, high, one in benefit.motions), strict=True)))
    return Table([Column(name) for name in names], rows)


def errors(benefit: Benefit) -> Iterator[tuple[str, Table]]:
    """Yield a figure of the errors on the simulated drives and its table, as ``predicted``."""

    def motion(name: str) -> Column:
        def both(one: MotionErrors, show: Callable[[float], str]) -> str:
            low, high = map(show, one.interval)
            return f"{show(one.median.ratio)} ({low} to {high})"

        return Column(
            name,
            lambda row: both(row[name], size_or_dash),
            name,
            name,
            cell=lambda row: both(row[name], lambda size: number(size, 2)),
            words=False,
        )

    every = [*benefit.motions, *by_motion(benefit.beyond)]
    for figure in dict.fromkeys(one.rows[0].figure for one in every):
        rows: dict[float, dict[str, Any]] = {}
        for one in every:
            if one.rows[0].figure == figure:
                friction = "as in the log" if one.level == 1.0 else f"{one.level:g} times"
                friction += "" if one in benefit.motions else ", not counted"
                row = rows.setdefault(one.level, {"friction": friction})
                row[one.rows[0].command] = one
        motions = dict.fromkeys(one.rows[0].command for one in every)
        name = Column("friction", "", "friction", "Friction")
        ordered = [rows[level] for level in sorted(rows)]
        yield figure, Table((name, *map(motion, motions)), ordered)


def benefit_text(benefit: Benefit, name: str) -> str:
    """Return these tables for a terminal, with the name of the compensator."""
    share = "" if benefit.share == 1.0 else f" at {benefit.share:g} of its force"
    return "\n".join(
        f"\nRMS error of {figure} with {name}{share} over that without compensation, median of"
        f" simulated drives (where that of the true one is expected):\n{table.text()}"
        for figure, table in errors(benefit)
    )


def tracking_scales(without: TrackingError, motion: Motion) -> tuple[Scale, Scale]:
    """Return the units of errors of velocity and position, from those without compensation."""
    velocity = velocity_scale(motion, without.velocity_rms)
    return velocity, position_scale(motion, without.position_rms)


def tracking(found: Tracking, motion: Motion) -> Table:
    """Return tracking errors, measured and simulated, without and with the compensator."""
    velocity, position = tracking_scales(found.errors()[NONE], motion)

    def scale(row: Row) -> Scale:
        return velocity if row["error"].startswith("velocity") else position

    errors = {"Simulated, without": NONE, "Simulated, with": FEEDFORWARD}
    errors["Simulated, no friction"] = FRICTIONLESS
    sizes = found.errors() | ({"measured": found.measured} if found.measured else {})
    columns = (
        Column("error", lambda row: error_title(row["error"], motion), "error", "Error"),
        units(scale),
        *([scaled("measured", scale, "Measured, log")] if found.measured else ()),
        *(scaled(name, scale, head) for head, name in errors.items()),
        share("reduction", "Reduction"),
    )
    rows = [
        {"error": key, "reduction": found.reduction(key)}
        | {name: getattr(one, key) for name, one in sizes.items()}
        for key in TRACKING_FIGURES
    ]
    return Table(columns, rows)


def error_title(error: str, motion: Motion) -> str:
    """Return what a page calls an error of ``TRACKING_FIGURES``."""
    what, size = error.split("_")
    what = "velocity" if what == "velocity" else WORDS[motion][0]
    return f"{what.capitalize()}, {'RMS' if size == 'rms' else 'maximum'}"
