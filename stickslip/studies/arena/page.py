"""arena.html: heat maps, Pareto fronts, and a time plot of each cell on click."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from functools import partial
from importlib.resources import files

import numpy as np
import pandas as pd

from stickslip.compensators.entrants import Entrant
from stickslip.presentation.markup import Html, element, join, paragraph, quiet, table, tile
from stickslip.presentation.page import Illustration, Section, made_with
from stickslip.presentation.quantity import number
from stickslip.studies.arena.drawing import draw_circle, draw_pareto
from stickslip.studies.arena.motion_commands import COMMANDS, RADIUS
from stickslip.studies.arena.protocol import Arena
from stickslip.studies.arena.table import ALL, budget_text, ranking, relative_errors
from stickslip.studies.arena.validation import PER_STEP, WORST
from stickslip.thresholds import offer

TITLE = "Friction compensators compared"
FIGURES = ("pareto", "circle")
DEEP = 3.0
"""Factor on the error at which the colour of a cell is the deepest."""
_BETTER, _WORSE = (0, 79, 134), (224, 123, 0)
"""Colours of errors below and above those of the reference."""


def sections(arena: Arena, found: pd.DataFrame) -> list[Section]:
    """Return the sections of the page.

    Parameters
    ----------
    found : see ``table.arena_table``
    """
    shown = [
        _head(arena, found),
        _heat_maps(arena, found),
        _pareto(arena, found),
        _circle(arena, found),
        _protocol(arena),
        _failures(arena),
        Section("Made with", made_with(), _script(arena, found)),
    ]
    return [section for section in shown if section is not None]


def _head(arena: Arena, found: pd.DataFrame) -> Section:
    plan, order = arena.plan, ranking(found, arena.plan)
    drives, starts = len(plan.drives), plan.starts
    texts = [
        paragraph(
            f"{len(plan.entrants)} entrants on {drives} simulated"
            f" {'drive' if drives == 1 else 'drives'}. Each is tuned by the same genetic"
            f" algorithm from the encoder and the motor force ({budget_text(plan)}),"
            " and validated by the true velocity on motions on which it was not tuned,"
            f" {starts} {'run' if starts == 1 else 'runs'} each."
        )
    ]
    tiles = []
    for column, name in (("mean here", "tuned on each drive"), ("mean carried", "carried over")):
        ranked = order[column].dropna()
        if len(ranked):
            best = str(ranked.idxmin())
            worst = float(order[column.replace("mean", "worst")][best])
            beside = (
                f"{number(float(ranked[best]), 3)} times the error of {plan.reference}",
                f"at worst {number(worst, 3)}",
            )
            tiles.append(tile(f"Best over all drives, {name}", best, *beside))
    return Section("", *texts, element("div", *tiles, class_="tiles"))


def _heat_maps(arena: Arena, found: pd.DataFrame) -> Section | None:
    plan = arena.plan
    parts: list[Html | Illustration | list[Illustration]] = [
        paragraph(
            f"Error relative to that of {plan.reference}"
            f" ({plan.entrant(plan.reference).title}), tuned on the same drive: geometric mean over"
            f" {', '.join(c.title for c in COMMANDS.values() if c.ranked)}. Blue is better,"
            " orange worse. Entrants without knowledge of friction come first. A cell shows its"
            " errors over time when it is clicked."
        ),
        _choice(),
        _heat_map(arena, found, carried=False),
    ]
    if plan.nominal is not None:
        parts.append(_heat_map(arena, found, carried=True))
    marked = "" if not _marked(arena) else f" * Ms above {offer.SENSITIVITY:g}."
    parts.append(
        quiet(
            "Mean and worst are over the drives. A run that fails, or a loop that is unstable,"
            f" leaves an empty cell.{marked}"
        )
    )
    return Section("Who does best on which drive", *parts)


def _choice() -> Html:
    """Return the buttons that choose the command whose errors the heat maps show."""
    ranked = {name: one.title for name, one in COMMANDS.items() if one.ranked}
    buttons = (
        element("button", title, type="button", data_command=name, aria_pressed=pressed)
        for name, title, pressed in (
            (ALL, "all commands", "true"),
            *((name, title, "false") for name, title in ranked.items()),
        )
    )
    return element("div", *buttons, class_="choice", role="group", aria_label="Command")


def _heat_map(arena: Arena, found: pd.DataFrame, *, carried: bool) -> Html:
    plan = arena.plan
    wide = relative_errors(found, plan, carried=carried)
    order = ranking(found, plan)
    label = "carried" if carried else "here"
    nominal = plan.nominal.name if plan.nominal else ""
    marked = _marked(arena)
    heads = [element("th", "", scope="col")]
    heads += [
        element("th", element("span", drive.name.replace("_", " ")), scope="col", title=drive.title)
        for drive in plan.drives
    ]
    heads += [element("th", element("span", text), scope="col") for text in ("mean", "worst")]
    rows = []
    entrants = sorted((plan.entrant(name) for name in plan.entrants), key=_knowledge)
    for one in entrants:
        cells = [element("th", one.name, scope="row", title=one.title)]
        for drive in plan.drives:
            tuned_on = nominal if carried else drive.name
            value = float(wide[drive.name][one.name])
            mark = "*" if (drive.name, one.name, tuned_on) in marked else ""
            cells.append(_cell(value, mark, f"{drive.name}|{one.name}|{tuned_on}"))
        cells += [
            _cell(float(order[f"{figure} {label}"][one.name]), "", "", figure)
            for figure in ("mean", "worst")
        ]
        rows.append(element("tr", *cells))
    title = f"Tuned on {nominal}, carried over" if carried else "Tuned on the drive itself"
    whole = element(
        "table",
        element("caption", element("span", title)),
        element("thead", element("tr", *heads)),
        element("tbody", join(rows, "\n")),
        class_="heat",
    )
    return element("div", whole, class_="scroll", tabindex="0", role="region", aria_label=title)


def _knowledge(one: Entrant) -> tuple[bool, bool]:
    return one.knows_friction, len(one.parts) > 1


def _marked(arena: Arena) -> set[tuple[str, str, str]]:
    return {
        (drive, name, tuned_on)
        for (drive, name), document in arena.documents.items()
        for tuned_on, validated in document["validated"].items()
        if not validated["peaks"].get("Ms", np.inf) <= offer.SENSITIVITY
    }


def _cell(value: float, mark: str, place: str, figure: str = "") -> Html:
    """Return a cell of a place, or the figure of a row: its mean or worst value."""
    if not np.isfinite(value):
        return element("td", "–")
    depth = min(abs(np.log(value)) / np.log(DEEP), 1.0) * 0.85
    colour = _BETTER if value < 1.0 else _WORSE
    shade = ",".join(str(round(255 + depth * (c - 255))) for c in colour)
    ink = "#fff" if depth > 0.5 and value < 1.0 else "#1a1a1a"
    text = f"{value:.2f}{mark}" if value < 9.995 else f"{value:.3g}{mark}"
    look = {"style": f"background:rgb({shade});color:{ink}"}
    if figure:
        return element("td", text, data_figure=figure, **look)
    return element("td", element("button", text, type="button", data_cell=place), **look)


def _pareto(arena: Arena, found: pd.DataFrame) -> Section | None:
    points = _points(arena, found)
    text = (
        "Error is that of the first heat map, the mean over the drives. Control effort is the mean"
        " rate at which the force command changes along the trapezoid, relative to that of the"
        " controller alone or, where it is missing, of the reference. Learning time is"
        " the motion of the drive after which the training error was within 5 % of that at the"
        " end. The line joins entrants that no other one surpasses in both."
    )
    about = quiet(
        "Changed drive: the largest factor by which the error of the trapezoid grows on drives with"
        " 0.5 to 1.5 times the friction, 0.5 to 2 times the mass or 5 times the lag of the current"
        " loop. Resolution: error of slow reversals per step of the encoder [1/s]. States: numbers"
        " kept between samples."
    )
    shown = Illustration(
        "pareto",
        partial(draw_pareto, points),
        "Error against control effort, and against learning time, of each entrant",
        text,
    )
    wide = points.join(_further(found))
    rows = [
        (name, *(number(float(value), 3) if np.isfinite(value) else "–" for value in row))
        for name, row in zip(wide.index, wide.to_numpy(), strict=True)
    ]
    heads = (
        *("Entrant", "Error", "Control effort", "Learning time [s]", "Largest Ms"),
        *("Changed drive", "Resolution", "States"),
    )
    return Section(
        "Error, effort and learning time",
        shown,
        table(heads, rows, "Means over the drives"),
        about,
    )


def _further(found: pd.DataFrame) -> pd.DataFrame:
    """Return robustness, sensitivity to the encoder [1/s] and states, a row an entrant."""
    here = found[found["tuned_on"] == found["drive"]]
    means = here.pivot_table("median", "compensator", "metric")
    return means.reindex(columns=[WORST, PER_STEP, "states"])


def _points(arena: Arena, found: pd.DataFrame) -> pd.DataFrame:
    """Return error, effort, learning time [s] and Ms, a row an entrant that has all of them."""
    here = found[found["tuned_on"] == found["drive"]]

    def wide(metric: str, command: str | None) -> pd.DataFrame:
        rows = here[here["metric"] == metric]
        if command is not None:
            rows = rows[rows["command"] == command]
        return rows.pivot_table("median", "compensator", "drive")

    variation = wide("variation", "T")
    base = variation.loc["none" if "none" in variation.index else arena.plan.reference]
    order = ranking(found, arena.plan)
    columns = {
        "error": order["mean here"],
        "effort": np.exp(np.log(variation / base).mean(axis=1)),
        "time": wide("motion until tuned", None).mean(axis=1),
        "Ms": wide("Ms", None).max(axis=1),
    }
    return pd.DataFrame(columns).reindex(list(arena.plan.entrants)).dropna()


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
    picture = Illustration(
        "circle",
        partial(draw_circle, shown),
        "Radial error along a circle for several entrants",
        f"Radial error along a circle of {1e3 * RADIUS:g} mm at 4 rad/s on the drive {drive}, as in"
        " a circularity test: both axes have the same drive and compensator. The spikes at the"
        " quadrants are where an axis reverses.",
    )
    return Section("Quadrant glitches", picture)


def _protocol(arena: Arena) -> Section:
    plan = arena.plan
    drives = [(one.name, one.title, one.law) for one in plan.drives]
    entrants = [(name, plan.entrant(name).title) for name in plan.entrants]
    return Section(
        "Protocol",
        table(
            ("Drive", "", "Law"),
            drives,
            "Drives",
            (0, 1, 2),
        ),
        table(("Entrant", ""), entrants, "Entrants", (0, 1)),
        quiet(
            "What tunes does not know the parameters of a drive. Linear loops are limited to Ms"
            f" {offer.SENSITIVITY:g} while tuning. Start values are coarse, with the errors of a"
            " data sheet, and the same for all entrants. arena.csv has every metric."
        ),
    )


def _failures(arena: Arena) -> Section | None:
    rows = [(drive, name, reason) for (drive, name), reason in arena.reasons.items()]
    for (drive, name), document in arena.documents.items():
        for tuned_on, validated in document["validated"].items():
            if validated["reason"]:
                rows.append((drive, f"{name}, tuned on {tuned_on}", validated["reason"]))
    if not rows:
        return None
    return Section(
        "What failed", table(("Drive", "Entrant", "Reason"), rows, "Failures", (0, 1, 2))
    )


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


def _script(arena: Arena, found: pd.DataFrame) -> Html:
    """Return the time plots as data, and the script that draws one when its cell is clicked."""
    cells = {
        f"{drive}|{name}|{tuned_on}": validated["plots"]
        for (drive, name), document in arena.documents.items()
        for tuned_on, validated in document["validated"].items()
    }
    motions = {
        name: {
            "title": f"{one.title[:1].upper()}{one.title[1:]}",
            "duration": one.motion.duration,
            "unit": "Position error [µm]" if one.position else "Velocity error [mm/s]",
            "least": 1000 if one.position else 50,
        }
        for name, one in COMMANDS.items()
    }
    data: dict[str, object] = {"cells": cells, "motions": motions}
    data["reference"] = arena.plan.reference
    data["errors"], data["deep"] = _errors(arena, found), DEEP
    packed = gzip.compress(json.dumps(data, separators=(",", ":")).encode(), mtime=0)
    folder = files(__package__)
    look = folder.joinpath("arena.css").read_text(encoding="utf-8")
    code = folder.joinpath("arena.js").read_text(encoding="utf-8")
    return Html(
        f"<style>\n{look}</style>\n"
        f'<script type="application/gzip" id="data">{b64encode(packed).decode()}</script>\n'
        f'<script type="module">\n{code}</script>'
    )
