"""arena.html: heat maps of the errors, Pareto fronts, and the errors in each motion."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator
from numpy.typing import NDArray

from stickslip.presentation import style
from stickslip.presentation.interactive import name_points
from stickslip.presentation.markup import Html, parts
from stickslip.presentation.page import MADE_WITH, Section
from stickslip.presentation.quantity import number
from stickslip.studies.arena.motion_commands import COMMANDS
from stickslip.studies.arena.protocol import Plan
from stickslip.studies.arena.table import (
    budget_text,
    entrant_table,
    points,
    ranking,
    relative_errors,
    robust,
)
from stickslip.thresholds import offer

TEMPLATES = "studies/arena"
TITLE = "Friction compensators compared"
FIGURES = ("errors", "pareto")
_DEEP = 3.0  # Factor on the error at which the colour of a cell is the deepest
_NAMED = 8  # points that all have names in a figure


def sections(plan: Plan, found: pd.DataFrame) -> list[Section]:
    """Return the sections of the page from what ``table.arena_table`` returns."""
    ranked = {name: one.title for name, one in COMMANDS.items() if one.ranked}
    errors = Section(
        "Who does best on which drive",
        f"{TEMPLATES}/heat_maps.j2",
        {"errors": partial(draw_errors, plan, found)},
        plan=plan,
        ranked=ranked,
        tables={title: _table(plan, found, name, title) for name, title in ranked.items()},
        LIMIT=offer.SENSITIVITY,
    )
    pareto = Section(
        "Error, effort and learning time",
        f"{TEMPLATES}/pareto.j2",
        {"pareto": partial(draw_pareto, points(found, plan).dropna())},
        summary=entrant_table(found, plan),
    )
    protocol = Section(
        "Protocol",
        f"{TEMPLATES}/protocol.j2",
        drives=[(one.name, one.title, one.law) for one in plan.drives],
        entrants=[(name, plan.entrant(name).title) for name in plan.entrants],
        LIMIT=offer.SENSITIVITY,
    )
    failed = found.loc[found["reason"].fillna("") != "", ["drive", "compensator", "reason"]]
    rows = failed.drop_duplicates().to_numpy().tolist()
    table = "{{ table(['Drive', 'Entrant', 'Reason'], rows, 'Failures', [0, 1, 2]) }}"
    failures = [Section("What failed", table, rows=rows)] if rows else []
    return [_head(plan, found), errors, pareto, protocol, *failures, MADE_WITH]


def _head(plan: Plan, found: pd.DataFrame) -> Section:
    order, best = ranking(found, plan), []
    for column, name in (("mean here", "tuned on each drive"), ("mean carried", "carried over")):
        ranked = order[column].dropna()
        if len(ranked):
            first = str(ranked.idxmin())
            worst = float(order[column.replace("mean", "worst")][first])
            beside = (
                f"{number(float(ranked[first]), 3)} times the error of {plan.reference}",
                f"at worst {number(worst, 3)}",
            )
            best.append((f"Best over all drives, {name}", first, *beside))
    return Section("", f"{TEMPLATES}/head.j2", plan=plan, budget=budget_text(plan), best=best)


def _table(plan: Plan, found: pd.DataFrame, command: str, title: str) -> Html:
    """Return the relative errors in one motion, each entrant tuned on the drive itself."""
    wide = relative_errors(found, plan, carried=False, command=command)
    rows = [(name, *(number(float(x), 3) for x in row)) for name, *row in wide.itertuples()]
    return Html(parts.table(("Entrant", *wide.columns), rows, f"Relative errors, {title}"))


def maps_of(plan: Plan, found: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the relative errors by how the entrants were tuned."""
    maps = {"tuned on the drive itself": relative_errors(found, plan, carried=False)}
    if plan.nominal is not None:
        title = f"tuned on {plan.nominal.name}, carried over"
        maps[title] = relative_errors(found, plan, carried=True)
    return maps


def draw_errors(plan: Plan, found: pd.DataFrame) -> Figure:
    """Draw the heat maps."""
    maps, within = maps_of(plan, found), robust(found)
    figure = style.new_figure(style.PAGE, 22.0 + 4.4 * len(plan.entrants))
    panels = figure.subplots(1, len(maps), sharey=True, squeeze=False)[0]
    for axes, (title, wide) in zip(panels, maps.items(), strict=True):
        tuned_on = plan.nominal.name if plan.nominal and axes is not panels[0] else ""
        beyond = [
            [(drive, name, tuned_on or drive) not in within for drive in wide.columns]
            for name in wide.index
        ]
        draw_heat_map(axes, wide, title, np.array(beyond))
    return figure


def draw_heat_map(
    axes: Axes, wide: pd.DataFrame, title: str, marked: NDArray[np.bool_] | None = None
) -> None:
    """Draw errors on a logarithmic scale of colours, with their numbers, some with an asterisk."""
    colours = LinearSegmentedColormap.from_list("errors", [style.WITH, "#ffffff", style.WITHOUT])
    depth, values, size = np.log(_DEEP), wide.to_numpy(float), min(9.0, 70.0 / wide.shape[1])
    axes.imshow(np.log(values), colours, norm=TwoSlopeNorm(0.0, -depth, depth), aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        mark = "*" if marked is not None and marked[row, column] else ""
        text = f"{value:.2f}{mark}" if np.isfinite(value) else "–"
        ink = "white" if value < np.exp(-0.6 * depth) else "black"
        axes.text(column, row, text, ha="center", va="center", color=ink, size=size)
    axes.set_xticks(range(wide.shape[1]), list(wide.columns), rotation=60, ha="right")
    axes.set_yticks(range(wide.shape[0]), list(wide.index))
    axes.tick_params(length=0)
    axes.set_title(title, fontsize="medium")


def draw_pareto(points: pd.DataFrame) -> Figure:
    """Draw error against effort and against time [s], each entrant a row of the points."""
    figure = style.new_figure(style.PAGE, 105.0)
    panels = figure.subplots(1, 2, sharey=True)
    _front(panels[0], points["effort"], points["error"])
    panels[0].set(xlabel="Control effort, relative", ylabel="Relative error")
    _front(panels[1], points["time"].clip(lower=1.0), points["error"])
    panels[1].set(xlabel="Learning time [s], 1 for none")
    for axes, letter, title in zip(panels, "ab", ("effort", "learning time"), strict=True):
        style.name_panel(axes, letter, f"Error against {title}")
    return figure


def _front(axes: Axes, x: pd.Series[Any], y: pd.Series[Any]) -> None:
    """Draw points, and the line of those that none surpasses, with their names."""
    best = [
        name
        for name in x.index
        if not any((x[o] <= x[name]) & (y[o] <= y[name]) & (o != name) for o in x.index)
    ]
    best.sort(key=lambda name: float(x[name]))
    others = [name for name in x.index if name not in best]
    for names, colour, joined in ((best, style.WITH, "-"), (others, style.GREY, "")):
        (line,) = axes.plot(x[names], y[names], "o", ls=joined, color=colour, ms=3.7)
        name_points(line, names)
    for name in x.index if len(x) <= _NAMED else best:
        place = float(x[name]), float(y[name])
        axes.annotate(name, place, xytext=(4.0, 3.0), textcoords="offset points", fontsize=6.5)
    axes.set(xscale="log", yscale="log")
    axes.margins(x=0.12, y=0.06)
    for axis, low, high in ((axes.xaxis, *axes.get_xlim()), (axes.yaxis, *axes.get_ylim())):
        if high < 1.5 * low:
            axis.set_major_locator(MaxNLocator(4))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(NullLocator())
        else:
            style.log_ticks(axis, low, high, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0))
