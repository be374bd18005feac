"""arena.csv.gz: a row for each drive, entrant, command, metric, and drive that it was tuned on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from stickslip.presentation.table import Column, Table
from stickslip.studies.arena.metrics import ERROR
from stickslip.studies.arena.motion_commands import COMMANDS
from stickslip.studies.arena.protocol import Arena, Plan
from stickslip.studies.arena.validation import PER_STEP, WORST
from stickslip.thresholds import offer

COLUMNS = [
    *("drive", "law", "compensator", "command", "metric", "unit", "median", "worst"),
    *("tuned_on", "budget", "reason"),
]
RELATIVE = "relative error"
DIGITS = 4  # Significant digits of the figures
ALL = "all"  # The command of a row that is a mean over all commands
TUNING = {
    "cost": ("training error", "1"),
    "evaluations": ("evaluations", "1"),
    "seconds": ("motion", "s"),
    "soon": ("motion until tuned", "s"),
}
"""Figures of ``TuningResult`` that are rows, their metrics and units."""


def arena_table(arena: Arena) -> pd.DataFrame:
    """Return the table, in SI units.

    ``worst`` is the largest value of all starts. ``relative error`` is the error over the median
    of the plan's reference, tuned on the same drive; for the command ``all`` the geometric mean of
    those of all commands.
    """
    rows = [row for place in arena.documents for row in _rows(arena, place)]
    table = pd.DataFrame(rows, columns=COLUMNS).astype({"median": float, "worst": float})
    table = pd.concat([table, _relative(table, arena.plan.reference)], ignore_index=True)
    failed = [
        {
            "drive": drive,
            "law": _law(arena.plan, drive),
            "compensator": name,
            "budget": budget_text(arena.plan),
            "reason": reason,
        }
        for (drive, name), reason in arena.reasons.items()
    ]
    table = pd.concat([table, pd.DataFrame(failed, columns=COLUMNS)], ignore_index=True)
    order = {drive.name: k for k, drive in enumerate(arena.plan.drives)}
    entrants = {name: k for k, name in enumerate(arena.plan.entrants)}
    keys = table["drive"].map(order) * len(entrants) + table["compensator"].map(entrants)
    table = table.assign(key=keys).sort_values("key", kind="stable")[COLUMNS]
    figures = ["median", "worst"]
    table[figures] = table[figures].astype(float).map(_rounded)
    return table.reset_index(drop=True)


def relative_errors(
    table: pd.DataFrame, plan: Plan, *, carried: bool, command: str = ALL
) -> pd.DataFrame:
    """Return the errors relative to the reference, a row an entrant, a column a drive."""
    rows = table[(table["metric"] == RELATIVE) & (table["command"] == command)]
    nominal = plan.nominal.name if plan.nominal else ""
    chosen = rows["tuned_on"] == (nominal if carried else rows["drive"])
    return medians(rows[chosen], plan)


def medians(rows: pd.DataFrame, plan: Plan) -> pd.DataFrame:
    """Return the medians of rows of one metric, a row an entrant, a column a drive."""
    wide = rows.pivot_table("median", "compensator", "drive")
    return wide.reindex(list(plan.entrants)).reindex(columns=[one.name for one in plan.drives])


def ranking(table: pd.DataFrame, plan: Plan) -> pd.DataFrame:
    """Return a row an entrant: geometric mean and worst of its relative errors over the drives."""
    columns = {}
    for label, carried in (("here", False), ("carried", True)):
        wide = relative_errors(table, plan, carried=carried)
        columns[f"mean {label}"] = wide.apply(_geometric, axis=1)
        columns[f"worst {label}"] = wide.max(axis=1, skipna=False)
    return pd.DataFrame(columns)


def points(table: pd.DataFrame, plan: Plan) -> pd.DataFrame:
    """Return error, effort, learning time [s] and largest Ms over the drives, a row an entrant."""
    here = table[table["tuned_on"] == table["drive"]]

    def wide(metric: str, rows: pd.DataFrame = here) -> pd.DataFrame:
        return rows[rows["metric"] == metric].pivot_table("median", "compensator", "drive")

    variation = wide("variation", here[here["command"] == "T"])
    base = variation.loc["none" if "none" in variation.index else plan.reference]
    columns = {
        "error": ranking(table, plan)["mean here"],
        "effort": np.exp(np.log(variation / base).mean(axis=1)),
        "time": wide("motion until tuned").mean(axis=1),
        "Ms": wide("Ms").max(axis=1),
    }
    return pd.DataFrame(columns).reindex(list(plan.entrants))


RANKING = (
    Column("compensator", "", "", "Entrant"),
    Column("mean here", ".3f", "mean here", "Error", digits=3),
    Column("worst here", ".3f", "worst"),
    Column("mean carried", ".3f", "mean carried over"),
    Column("worst carried", ".3f", "worst"),
    Column("effort", head="Control effort", digits=3),
    Column("time", head="Learning time [s]", digits=3),
    Column("Ms", head="Largest Ms", digits=3),
    Column(WORST, head="Changed drive", digits=3),
    Column(PER_STEP, head="Resolution", digits=3),
    Column("states", head="States", digits=3),
)
"""Means of an entrant over the drives; metrics of arena.csv.gz by their names."""


def entrant_table(table: pd.DataFrame, plan: Plan) -> Table:
    """Return what became of each entrant over all drives."""
    here = table[table["tuned_on"] == table["drive"]]
    means = here.pivot_table("median", "compensator", "metric")
    found = ranking(table, plan).join(points(table, plan))
    found = found.join(means.drop(columns=means.columns.intersection(found.columns)))
    found = found.reindex(columns=[one.name for one in RANKING[1:]]).astype(float)
    rows = found.map(_rounded).rename_axis("compensator")
    return Table.of(RANKING, rows.reset_index())


def budget_text(plan: Plan) -> str:
    """Return the budget of each entrant on each drive."""
    return f"{plan.budget.evaluations} evaluations, {plan.budget.seconds:g} s of motion"


def robust(table: pd.DataFrame) -> set[tuple[str, str, str]]:
    """Return drive, entrant, and drive that it was tuned on where Ms is within the limit."""
    rows = table[(table["metric"] == "Ms") & (table["median"] <= offer.SENSITIVITY)]
    return set(rows[["drive", "compensator", "tuned_on"]].itertuples(index=False, name=None))


def _law(plan: Plan, drive: str) -> str:
    return next(one.law for one in plan.drives if one.name == drive)


def _rows(arena: Arena, place: tuple[str, str]) -> Iterator[dict[str, Any]]:
    document, (drive, name) = arena.documents[place], place
    for tuned_on, validated in document["validated"].items():
        same = {
            "drive": drive,
            "law": _law(arena.plan, drive),
            "compensator": name,
            "tuned_on": tuned_on,
            "budget": budget_text(arena.plan),
        }
        peak = validated["peaks"].get("Ms", np.inf)
        reason = validated["reason"]
        if not peak <= offer.SENSITIVITY:
            reason = reason or f"Ms = {peak:.3g}, expected at most {offer.SENSITIVITY:g}"
        same["reason"] = reason
        for command, metric, unit, values in validated["values"]:
            yield {
                **same,
                "command": command,
                "metric": metric,
                "unit": unit,
                "median": float(np.median(values)),
                "worst": float(np.max(values)),
            }
        units = {"phase margin": "rad", "binary size": "B", **dict(TUNING.values())}
        found = {**validated["peaks"], **document["footprint"]}
        found |= {metric: document["tuned"][tuned_on][key] for key, (metric, _) in TUNING.items()}
        for metric, value in found.items():
            unit = units.get(metric, "1")
            yield {**same, "metric": metric, "unit": unit, "median": value, "worst": value}


def _relative(table: pd.DataFrame, reference: str) -> pd.DataFrame:
    """Return the rows of the errors relative to those of an entrant tuned on the same drive."""
    errors = table[table["metric"] == ERROR]
    own = errors[(errors["compensator"] == reference) & (errors["tuned_on"] == errors["drive"])]
    known: Mapping[Any, float] = own.set_index(["drive", "command"])["median"].to_dict()
    places = list(zip(errors["drive"], errors["command"], strict=True))
    scale = np.array([known.get(place, 0.0) for place in places])
    errors, scale = errors[scale > 0.0], scale[scale > 0.0]
    found = errors.assign(
        metric=RELATIVE,
        unit="1",
        median=errors["median"].to_numpy(float) / scale,
        worst=errors["worst"].to_numpy(float) / scale,
    )
    keys = [name for name in COLUMNS if name not in ("command", "median", "worst")]
    ranked = found["command"].isin([name for name, one in COMMANDS.items() if one.ranked])
    groups = found[ranked].groupby(keys, sort=False)[["median", "worst"]]
    means = pd.DataFrame(groups.agg(_geometric)).reset_index()
    both: pd.DataFrame = pd.concat([found, means.assign(command=ALL)], ignore_index=True)
    return both


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _geometric(values: pd.Series[float]) -> float:
    numbers = values.to_numpy(float)
    return float(np.exp(np.mean(np.log(numbers)))) if (numbers > 0.0).all() else float("nan")
