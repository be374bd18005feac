"""The tables of what was learned of a log, as the terminal, the page and the files have them."""

from __future__ import annotations

from stickslip.catalog.parameters import unit_of
from stickslip.identification.estimation import Estimation
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.presentation.markup import prose
from stickslip.presentation.quantity import (
    interval,
    meaning,
    number,
    percentage,
    symbol,
    with_error,
)
from stickslip.presentation.scale import Scale, parameter_scale
from stickslip.presentation.table import Column, Row, Table
from stickslip.trial.candidates import CompensatorComparison
from stickslip.trial.guards import Benefit
from stickslip.trial.observed import ObserverTrial


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
        Column("sentence", text="", head="How well", cell=lambda row: prose(row["sentence"])),
    )
    rows = [
        {"parameter": name, "meaning": "", "unit": unit_of(name, rotary=recording.rotary)}
        | {column.name: getattr(known, column.name) for column in columns[3:]}
        for name, known in estimation.known.items()
    ]
    return Table(columns, rows)


def laws(estimation: Estimation) -> Table:
    """Return the force error of each law that was tried, where it was not fitted."""
    unit = unit_of("F_c", rotary=estimation.recording.rotary)
    columns = (
        Column("law", text="", title="law", head="Friction law"),
        Column(
            "held_out_error",
            text=".3g",
            title=f"error [{unit}]",
            head=f"Error where not fitted [{unit}]",
            digits=3,
            unit=unit,
        ),
        Column(
            "relative",
            text=lambda row: f"{100.0 * row['relative']:.3g} %",
            head="Of the force",
            cell=lambda row: percentage(row["relative"]),
            unit="1",
        ),
        Column(
            "explained",
            text=".3g",
            title="noise and steps explain",
            head=f"Explained [{unit}]",
            digits=3,
            unit=unit,
        ),
    )
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


RATIOS = (
    Column("fitted", text=".3g", title="fitted drive", head="Fitted drive"),
    Column("mean", text=".3g", title="mean", head="Mean"),
    Column("worst", text=".4g", title="worst", head="Worst"),
)
"""Errors relative to those without compensation: of the fitted drive the geometric mean over the
commands, that over all drives, and the largest."""
ACCEPTABLE = Column(
    "acceptable",
    text=lambda row: "" if row["acceptable"] else "worse than none",
    head="Never worse",
    cell=lambda row: "yes" if row["acceptable"] else "no",
)


def ratios(benefit: Benefit | None) -> dict[str, float]:
    """Return the values of ``RATIOS``; 1 without compensation."""
    if benefit is None:
        return {"fitted": 1.0, "mean": 1.0, "worst": 1.0}
    found = benefit.fitted_ratio, benefit.mean_ratio, benefit.worst_ratio
    return dict(zip((column.name for column in RATIOS), found, strict=True))


def compensators(compared: CompensatorComparison) -> Table:
    """Return what each compensator that was tried leaves of the error without compensation."""
    columns = (
        Column("compensator", text="", title="compensator", head="Compensator"),
        *RATIOS,
        Column("Ms", text=".3g", title="Ms", head="$M_s$"),
        ACCEPTABLE,
    )
    rows = [
        {"compensator": row.name, "Ms": row.sensitivity, "acceptable": row.acceptable}
        | ratios(row.benefit)
        for row in compared.rows
    ]
    return Table(columns, rows)


def parts(observed: ObserverTrial) -> Table:
    """Return what feedforward, disturbance observer and both leave of that error."""
    columns = (
        Column("part", text="", title="compensation", head="Compensation"),
        Column("share"),
        *RATIOS,
        ACCEPTABLE,
    )
    rows = [
        {
            "part": name,
            "share": one.share if one.variant.has_feedforward else float("nan"),
            "acceptable": one.acceptable,
        }
        | ratios(one)
        for name, one in observed.parts.items()
    ]
    return Table(columns, rows)
