"""arena.html: heat maps, Pareto fronts, a circle, and a time plot of each cell on click."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator

from stickslip.compensators.entrants import Entrant
from stickslip.presentation import style
from stickslip.presentation.interactive import name_points
from stickslip.presentation.markup import Html
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import number
from stickslip.studies.arena.motion_commands import COMMANDS, RADIUS
from stickslip.studies.arena.protocol import Arena
from stickslip.studies.arena.table import (
    ALL,
    budget_text,
    entrant_table,
    points,
    ranking,
    relative_errors,
    settings_text,
)
from stickslip.thresholds import offer

TEMPLATES = "studies/arena"
TITLE = "Friction compensators compared"
FIGURES = ("pareto", "circle")
MOTIONS = 60  # cells of a page that has their motions; of more it has the commands
DEEP = 3.0  # Factor on the error at which the colour of a cell is the deepest
_BETTER, _WORSE = (0, 79, 134), (224, 123, 0)
"""Colours of errors below and above those of the reference."""


def sections(arena: Arena, found: pd.DataFrame) -> list[Section]:
    """Return the sections of the page, from what ``table.arena_table`` returns, too."""
    plan = arena.plan
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
    made = Section("Made with", f"{TEMPLATES}/script.j2", None, **_script(arena, found))
    shown = [_head(arena, found), _heat_maps(arena, found), pareto, _circle(arena, found), protocol]
    shown += [_failures(arena), made]
    return [section for section in shown if section is not None]


def _head(arena: Arena, found: pd.DataFrame) -> Section:
    plan, order, best = arena.plan, ranking(found, arena.plan), []
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


def _heat_maps(arena: Arena, found: pd.DataFrame) -> Section:
    plan = arena.plan
    maps = {"Tuned on the drive itself": _heat_map(arena, found, carried=False)}
    if plan.nominal is not None:
        title = f"Tuned on {plan.nominal.name}, carried over"
        maps[title] = _heat_map(arena, found, carried=True)
    return Section(
        "Who does best on which drive",
        f"{TEMPLATES}/heat_maps.j2",
        plan=plan,
        ranked={name: one.title for name, one in COMMANDS.items() if one.ranked},
        maps=maps,
        marked=marked(arena),
        shown=bool(_motions(arena)),
        LIMIT=offer.SENSITIVITY,
    )


def _motions(arena: Arena) -> dict[str, dict[str, list[int]]]:
    """Return the errors over time by place; none where there are more than ``MOTIONS`` cells."""
    found = {
        f"{drive}|{name}|{tuned_on}": validated["plots"]
        for (drive, name), document in arena.documents.items()
        for tuned_on, validated in document["validated"].items()
    }
    return found if len(found) <= MOTIONS else {}


def _heat_map(
    arena: Arena, found: pd.DataFrame, *, carried: bool
) -> list[tuple[Entrant, list[dict[str, str]]]]:
    """Return the cells of each entrant: its errors on the drives, their mean and the worst."""
    plan, beyond = arena.plan, marked(arena)
    wide, order = relative_errors(found, plan, carried=carried), ranking(found, plan)
    nominal, label = plan.nominal.name if plan.nominal else "", "carried" if carried else "here"
    rows = []
    entrants = map(plan.entrant, plan.entrants)
    for one in sorted(entrants, key=lambda one: (one.knows_friction, len(one.parts) > 1)):
        cells = []
        for drive in plan.drives:
            place = drive.name, one.name, nominal if carried else drive.name
            mark = "*" if place in beyond else ""
            value = float(wide[drive.name][one.name])
            cells.append(_cell(value, mark) | {"place": "|".join(place), "figure": ""})
        for figure in ("mean", "worst"):
            value = float(order[f"{figure} {label}"][one.name])
            cells.append(_cell(value) | {"figure": figure})
        rows.append((one, cells))
    return rows


def marked(arena: Arena) -> set[tuple[str, str, str]]:
    """Return drive, entrant, and drive that it was tuned on where Ms is above the limit."""
    return {
        (drive, name, tuned_on)
        for (drive, name), document in arena.documents.items()
        for tuned_on, validated in document["validated"].items()
        if not validated["peaks"].get("Ms", np.inf) <= offer.SENSITIVITY
    }


def _cell(value: float, mark: str = "") -> dict[str, str]:
    """Return text and style of a cell; empty where there is no value."""
    if not np.isfinite(value):
        return {"text": ""}
    depth = min(abs(np.log(value)) / np.log(DEEP), 1.0) * 0.85
    colour = _BETTER if value < 1.0 else _WORSE
    shade = ",".join(str(round(255 + depth * (c - 255))) for c in colour)
    ink = "#fff" if depth > 0.5 and value < 1.0 else "#1a1a1a"
    text = f"{value:.2f}{mark}" if value < 9.995 else f"{value:.3g}{mark}"
    return {"text": text, "style": f"background:rgb({shade});color:{ink}"}


def _circle(arena: Arena, found: pd.DataFrame) -> Section | None:
    """Return the polar picture of a circle on the nominal drive: none, the reference, the best."""
    drive = (arena.plan.nominal or arena.plan.drives[0]).name
    order = ranking(found, arena.plan)["mean here"].dropna()
    plain = dict.fromkeys(("none", arena.plan.reference))
    best = [str(name) for name in order.sort_values().index if str(name) not in plain]
    shown = {
        name: arena.documents[drive, name]["validated"][drive]["circle"]
        for name in (*plain, *best[:1])
        if (drive, name) in arena.documents
    }
    shown = {name: values for name, values in shown.items() if values}
    if not shown:
        return None
    draw = {"circle": partial(draw_circle, shown)}
    return Section("Quadrant glitches", f"{TEMPLATES}/circle.j2", draw, drive=drive, RADIUS=RADIUS)


def _failures(arena: Arena) -> Section | None:
    rows = [(drive, name, reason) for (drive, name), reason in arena.reasons.items()]
    for (drive, name), document in arena.documents.items():
        for tuned_on, validated in document["validated"].items():
            if validated["reason"]:
                rows.append((drive, f"{name}, tuned on {tuned_on}", validated["reason"]))
    if not rows:
        return None
    table = "{{ table(['Drive', 'Entrant', 'Reason'], rows, 'Failures', [0, 1, 2]) }}"
    return Section("What failed", table, rows=rows)


def _errors(arena: Arena, found: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Return the relative errors by place and command."""
    plan, errors = arena.plan, dict[str, dict[str, float]]()
    nominal = plan.nominal.name if plan.nominal else ""
    for command in (ALL, *COMMANDS):
        for carried in (False, True):
            wide = relative_errors(found, plan, carried=carried, command=command)
            for drive in wide.columns:
                for name, value in wide[drive].dropna().items():
                    place = f"{drive}|{name}|{nominal if carried else drive}"
                    errors.setdefault(place, {})[command] = float(f"{value:.4g}")
    return errors


def _script(arena: Arena, found: pd.DataFrame) -> dict[str, Html]:
    """Return the time plots as data, and the script that draws one when its cell is clicked."""
    plan = arena.plan
    motions = {
        name: {
            "title": f"{one.title[:1].upper()}{one.title[1:]}",
            "duration": one.motion.duration,
            "unit": "Position error [µm]" if one.position else "Velocity error [mm/s]",
            "least": 1000 if one.position else 50,
        }
        for name, one in COMMANDS.items()
    }
    data: dict[str, object] = {"cells": _motions(arena), "motions": motions}
    data["reference"], data["settings"] = plan.reference, settings_text(plan)
    data["errors"], data["deep"] = _errors(arena, found), DEEP
    packed = gzip.compress(json.dumps(data, separators=(",", ":")).encode(), mtime=0)
    folder = files(__package__)
    look, code = (
        Html(folder.joinpath(name).read_text(encoding="utf-8"))
        for name in ("arena.css", "arena.js")
    )
    return {"look": look, "packed": Html(b64encode(packed).decode()), "code": code}


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
    figure.draw_without_rendering()
    for axes, x in zip(panels, ("effort", "time"), strict=True):
        _name_points(axes, points[x].clip(lower=1.0 if x == "time" else 0.0), points["error"])
    return figure


def _front(axes: Axes, x: pd.Series[Any], y: pd.Series[Any]) -> None:
    """Draw points with their names, and the line of those that none surpasses."""
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
    axes.set(xscale="log", yscale="log")
    axes.margins(x=0.12, y=0.06)
    for axis, low, high in ((axes.xaxis, *axes.get_xlim()), (axes.yaxis, *axes.get_ylim())):
        if high < 1.5 * low:
            axis.set_major_locator(MaxNLocator(4))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(NullLocator())
        else:
            style.log_ticks(axis, low, high, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0))


def _name_points(axes: Axes, x: pd.Series[Any], y: pd.Series[Any]) -> None:
    """Write the name of each point beside it where no other name is, the lowest points first."""
    places = axes.transData.transform(np.column_stack([x, y])) * 72.0 / axes.figure.dpi
    taken = [(px - 2.0, py - 2.0, px + 2.0, py + 2.0) for px, py in places]
    for k in np.argsort(y.to_numpy(), kind="stable"):
        name, (px, py) = str(x.index[k]), places[k]
        width, height = 3.1 * len(name), 6.0
        tries = [
            (side, dy) for dy in (0.0, 5.0, -5.0, 10.0, -10.0, 15.0, -15.0) for side in (1, -1)
        ]
        boxes = [
            (px + (4.0 if side > 0 else -4.0 - width), py + dy - 0.5 * height, side, dy)
            for side, dy in tries
        ]
        free = [
            (left, low, side, dy)
            for left, low, side, dy in boxes
            if all(
                left > b[2] or left + width < b[0] or low > b[3] or low + height < b[1]
                for b in taken
            )
        ]
        left, low, side, dy = (free or boxes)[0]
        taken.append((left, low, left + width, low + height))
        axes.annotate(
            name,
            (float(x.iloc[k]), float(y.iloc[k])),
            xytext=(4.0 * side, dy),
            textcoords="offset points",
            ha="left" if side > 0 else "right",
            va="center",
            fontsize=6.5,
            color=style.INK,
            arrowprops={"arrowstyle": "-", "lw": 0.3, "color": style.GREY, "shrinkB": 2.0}
            if dy
            else None,
        )


def draw_circle(shown: Mapping[str, Sequence[int]]) -> Figure:
    """Draw the radial error along a circle from the position error [nm] of one axis, by entrant."""
    figure = style.new_figure(style.PAGE, 68.0)
    panels = figure.subplots(1, len(shown), squeeze=False, subplot_kw={"projection": "polar"})[0]
    radial = {}
    for name, values in shown.items():
        # A turn begins where x is least, at half a turn; y is a quarter of a turn behind.
        x = np.array([*values], dtype=float) / 1000.0
        y = np.roll(x, len(x) // 4)
        angle = np.pi + 2.0 * np.pi * np.arange(len(x)) / len(x)
        radial[name] = angle, x * np.cos(angle) + y * np.sin(angle)
    size = max(float(np.abs(error).max()) for _, error in radial.values())
    for axes, (name, (angle, error)) in zip(panels, radial.items(), strict=True):
        around = np.linspace(0.0, 2.0 * np.pi, 200)
        axes.plot(around, np.full(200, 0.0), color=style.GREY, lw=style.THIN)
        axes.plot(np.append(angle, angle[0]), np.append(error, error[0]), color=style.WITH, lw=0.8)
        axes.set(rlim=(-3.0 * size, 1.2 * size), xticks=np.arange(4) * np.pi / 2.0, yticks=[])
        axes.set_xticklabels(["x", "y", "", ""])
        axes.set_title(f"{name}: ±{number(float(np.abs(error).max()), 2)} µm", loc="center")
        axes.grid(visible=False)
    return figure
