"""The tables, the figure and the files of a loop that was tuned."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.learned import deploying
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import component_entry, loop_document
from stickslip.models.export.units import motion_unit
from stickslip.presentation import style
from stickslip.presentation.page import Section, picture_files, write_page
from stickslip.presentation.quantity import number, unit
from stickslip.presentation.table import Column, Table
from stickslip.storage import completed
from stickslip.storage.codec import state
from stickslip.storage.writing import write_json
from stickslip.studies.learn import tables
from stickslip.studies.tune.run import PRESENT, TUNED, TunedDrive
from stickslip.sweeping import Optimum
from stickslip.thresholds import kept
from stickslip.trial.benefit import MotionErrors

FIGURE = "errors"
WIDTH = 0.5  # of the levels of friction beside each other in it, over the distance of motions
DOCUMENT, PARAMETERS, SEARCH, PAGE = "tuned.json", "parameters.csv", "search.csv", "report.html"
FMUS = tuple(f"{part}.fmu" for part in deploying.PARTS)
OWN = (DOCUMENT, PARAMETERS, SEARCH, PAGE, *FMUS)
FILES = (*OWN, *deploying.FILES, *picture_files([FIGURE]))
"""What ``write_tuned`` writes or removes."""
STALE = (
    *("predicted_error", "tracking_error", "tracking", "hold", "compared", "validation_errors"),
    *("verdict", "other_gains"),
)
"""Entries of learned.json that hold in the present loop only."""
COLUMNS = (
    Column("parameter", "", "parameter", "Parameter"),
    Column("unit", "", "unit", "Unit"),
    Column("before", ".6g", "before", "Before"),
    Column("after", ".6g", "after", "After"),
)


def parameters(found: TunedDrive) -> Table:
    """Return what was searched, before and after."""
    before, after = found.start.tunable, found.best.tunable
    rows = [
        {"parameter": name, "unit": found.start.unit(name)}
        | {"before": value, "after": after[name]}
        for name, value in before.items()
        if name in found.names and (value or after[name])
    ]
    return Table(COLUMNS, rows)


def changed(found: Optimum) -> Table:
    """Return what was searched of a system, before and after."""
    first = found.table.iloc[0]
    rows = [
        {"parameter": name, "unit": found.units[name], "before": float(first[name])}
        | {"after": value}
        for name, value in found.parameters.items()
    ]
    return Table(COLUMNS, rows)


def tuned_document(found: TunedDrive) -> dict[str, Any]:
    """Return the content of tuned.json: that of the learned.json with the loop as tuned."""
    learned, best = found.learned, found.best
    document = {name: one for name, one in learned.document.items() if name not in STALE}
    document["loop"] = loop_document(best.loop)
    document["verdict"] = verdict(found)
    of_drive = partial(motion_unit, rotary=learned.rotary)
    if best.feedforward:
        share = {"value": best.share, "unit": "1"}
        if "feedforward" in document:
            entry = component_entry(best.feedforward, rotary=learned.rotary)
            document["feedforward"] = entry | {"share": share}
        else:
            whole = learned.law.share(best.feedforward.values, 1.0 / best.share)
            units = {name: one.unit for name, one in learned.law.parameters.items()}
            document |= {"share": share, "compensator": state(whole, units, of_drive)}
    if best.observer:
        entry = component_entry(best.observer, rotary=learned.rotary)
        known = document["observer"]["parameters"]
        entry["parameters"] = {**known, **entry["parameters"]}
        document["observer"] = {**document["observer"], **entry}
        peaks = {"peak_sensitivity": {"value": found.Ms[1], "unit": "1"}}
        document["observer"] |= peaks
    elif "observer.fmu" in learned.written:  # a rig does not run it
        del document["observer"]
    held = "position_force.fmu" in learned.written and learned.position_force
    has = dict(zip(FMUS, (best.feedforward, held, best.observer), strict=True))
    files = [name for name, one in has.items() if one]
    document["written"] = {"files": files}
    document["tuning"] = {
        "from": learned.path.name,
        "sentence": found.sentence,
        "parameters": parameters(found).records(),
        "Ms": {"before": found.Ms[0], "after": found.Ms[1], "masses": list(found.masses)},
        "ratios": [
            {"motion": motion, "figure": figure, "of": kind, "ratio": ratio}
            for (motion, figure, kind), ratio in found.ratios.items()
        ],
        "by_friction": tables.predicted(found.benefit).records(),
        "evaluations": len(found.history),
        "seed": found.settings.seed,
    }
    if (shown := found.on_rig) is not None:
        rig = {"rig": shown.rig, "motions": shown.table.records(), "budget": shown.budget}
        document["tuning"]["on_rig"] = rig | {"stopped": shown.stopped, "used": len(shown.motions)}
    return document


def verdict(found: TunedDrive) -> dict[str, Any]:
    """Return what is to be known first; what was learned is in doubt as before."""
    stated = found.learned.document.get("verdict") or {}
    doubts = stated.get("doubts", [])
    changes = [
        f"{row['parameter']} = {number(row['after'], 4)} {unit(row['unit'])}".rstrip()
        + f", before {number(row['before'], 4)}"
        for row in parameters(found).rows
        if row["after"] != row["before"]
    ]
    lines = [*(["set", one] for one in changes), *(["uncertain", one] for one in doubts)]
    source = stated.get("source", found.learned.path.name)
    return {"source": source, "headline": found.sentence, "doubts": doubts, "lines": lines}


def write_tuned(found: TunedDrive, folder: Path | str) -> None:
    """Write tuned.json, tables, the page, the compensators and, in ``deploy``, how to use them.

    Raises OSError when a file cannot be written.
    """
    command = {"name": "tune", "learned": str(found.learned.path), "seed": found.settings.seed}
    frames = {PARAMETERS: parameters(found).frame(), SEARCH: found.history}
    with completed(Path(folder), command, FILES, frames) as staging:
        write_json(tuned_document(found), staging / DOCUMENT)
        learned = LearnedFile(staging / DOCUMENT)  # the blocks are those that export would give
        deploying.build_parts(learned, staging)
        if learned.written:
            deploying.write_deployment(learned, staging / deploying.FOLDER)
        section = Section(
            "",
            "studies/tune/page.j2",
            {FIGURE: partial(draw_errors, found)} if found.is_better else {},
            found=found,
            levels=sorted({row.level for row in found.rows}),
            parameters=parameters(found),
            errors=[*tables.errors(found.benefit)],
            kept=kept,
            deployed=bool(learned.written),
        )
        write_page(staging, "Tuned loop", [section], PAGE)


def write_optimised(found: Optimum, source: Path, cost: Path, folder: Path) -> None:
    """Write tuned.json, tables and the page of a system that was tuned."""
    table = changed(found)
    frames = {PARAMETERS: table.frame(), SEARCH: found.table}
    with completed(folder, {"name": "tune", "system": str(source)}, FILES, frames) as staging:
        document = {"system": source.name, "criterion": cost.name, "cost": found.cost}
        document |= {"parameters": table.by_key(), "stopped": found.stopped}
        document["verdict"] = {"headline": sentence_of(found)}
        write_json(document, staging / DOCUMENT)
        text = "<p>{{ sentence }}.</p>{{ table.html('Parameters of the system') }}"
        section = Section("", text, sentence=sentence_of(found), table=table)
        write_page(staging, f"{source.name}, tuned", [section], PAGE)


def sentence_of(found: Optimum) -> str:
    """Return what a search brought, in a sentence without its end."""
    before, runs = found.table["cost"].iloc[0], len(found.table)
    return f"The cost is {found.cost:.6g} instead of {before:.6g} after {runs} runs{found.at_end}"


def draw_errors(found: TunedDrive) -> Figure:
    """Draw a panel for velocity and, in a cascade, position."""
    motions = found.benefit.motions
    figures = list(dict.fromkeys(one.rows[0].figure for one in motions))
    figure = style.new_figure(style.COLUMN, 20.0 + 48.0 * len(figures))
    panels = figure.subplots(len(figures), 1, sharex=True, squeeze=False)[:, 0]
    for axes, letter, name in zip(panels, "ab", figures, strict=False):
        own = [one for one in motions if one.rows[0].figure == name]
        factor, unit = found.benefit.shown(own[0].rows[0])
        _draw(axes, own, factor)
        axes.set_ylabel(f"RMS error [{unit.replace('u', 'µ')}]")
        style.name_panel(axes, letter, name.capitalize())
    style.legend_below(panels[0])
    figure.align_ylabels(panels)
    return figure


def _draw(axes: Axes, motions: list[MotionErrors], factor: float) -> None:
    names = list(dict.fromkeys(one.rows[0].command for one in motions))
    levels = sorted({one.level for one in motions})
    shifts = dict(zip(levels, np.linspace(-WIDTH / 2, WIDTH / 2, len(levels)), strict=True))
    x = [names.index(one.rows[0].command) + shifts[one.level] for one in motions]
    # Over the drives on which the present loop does not run away.
    pairs = [
        [(row.without, row.compensated) for row in one.rows if math.isfinite(row.without)]
        for one in motions
    ]
    errors = factor * np.array([np.sqrt(np.mean(np.square(pair), axis=0)) for pair in pairs])
    axes.vlines(x, *errors.T, color=style.GREY, lw=style.THIN)
    axes.plot(x, errors[:, 0], "o", color=style.WITHOUT, mfc="white", label=PRESENT)
    axes.plot(x, errors[:, 1], "o", color=style.WITH, label=TUNED)
    axes.set_yscale("log")
    style.log_ticks(axes.yaxis, errors.min(), errors.max())
    axes.grid(visible=True, axis="y")
    axes.set_xticks(range(len(names)), [re.sub(r" |(?<=-)", "\n", name) for name in names])
