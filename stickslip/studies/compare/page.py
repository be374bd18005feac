"""Several drives side by side: a panel for each parameter, a line for each drive."""

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from stickslip.identification.fitting.identifiability import (
    IDENTIFIABLE,
    NOT_IDENTIFIABLE,
    WEAKLY_IDENTIFIABLE,
)
from stickslip.presentation import style
from stickslip.presentation.interactive import name_points
from stickslip.presentation.markup import Html
from stickslip.presentation.page import MADE_WITH, Section
from stickslip.presentation.table import Table
from stickslip.servo.measurement import Array
from stickslip.studies.compare.tables import readable_unit

LOOKS = {
    NOT_IDENTIFIABLE: (style.GREY, "white", style.THIN),
    WEAKLY_IDENTIFIABLE: (style.WITHOUT, style.WITHOUT, style.LINE),
    IDENTIFIABLE: (style.WITH, style.WITH, style.LINE),
}
"""Colour of the line and of the inside of the dot, and width of the line [pt]."""
NUMBERS = ("value", "low", "high")
SYMBOLS = {"sigma_0": r"\sigma_0", "sigma_1": r"\sigma_1"}
COLUMNS = 4
PITCH = 4.2  # From one drive's line to the next, where there is room [mm]
NAMED = 40  # So many lines can be named; of more drives only some are
DECADES = 3.0  # A panel whose values differ by more than this factor is logarithmic
ROOM = 0.12  # Left free beside the outermost values, as a share of their range
LONGEST = 190.0  # Of all lines of a panel [mm]


def drives_sections(
    parameters: Table, head: Html, file: str, errors: Table | None = None
) -> list[Section]:
    """Return the sections of a page on several drives, with a figure of this name."""
    table = parameters.frame()
    learned = [row for row in parameters.rows if isinstance(row.get("parameter"), str)]
    order = {name: k for k, name in enumerate(dict.fromkeys(row["parameter"] for row in learned))}
    rows = sorted(learned, key=lambda row: order[row["parameter"]])
    figures = {file: partial(drives_figure, table)} if learned else {}
    drives = {"head": head, "file": file, "drawn": bool(learned)}
    sections = [
        Section("", "studies/compare/drives.j2", figures, **drives),
        Section(
            "Parameters",
            "{{ found.html('Parameters by result') }}",
            found=Table(sorted(parameters.columns, key=lambda one: one.name != "parameter"), rows),
        ),
    ]
    if errors is not None:
        caption = (
            "Simulated tracking error with the compensator over that without: on the fitted drive, "
            "and the worst on the drives that the log supports"
        )
        found = {"found": errors, "caption": caption}
        sections.append(Section("Compensators", "{{ found.html(caption) }}", None, **found))
    return [*sections, MADE_WITH]


def drives_figure(table: pd.DataFrame) -> Figure:
    """Return a figure with a panel for each parameter and a line for each drive.

    Values stand with their 95 % intervals. What is not identifiable does not set the range of its
    panel. Drives that failed keep an empty line.
    """
    names = list(dict.fromkeys(table["name"]))
    learned = table[table["parameter"].notna()]
    panels: list[tuple[Any, pd.DataFrame]] = list(
        learned.groupby(["parameter", "unit"], sort=False)
    )
    rows = -(-len(panels) // COLUMNS)
    height = min(max(PITCH * len(names), 12.0), LONGEST / rows)
    figure = style.new_figure(style.PAGE, 12.0 + rows * (height + 17.0))
    first: Axes | None = None
    for k, (key, of_it) in enumerate(panels):
        parameter, unit = key
        axes = figure.add_subplot(rows, COLUMNS, k + 1, sharey=first)
        first = first or axes
        scale, unit = readable_unit(parameter, unit)
        scaled = of_it.assign(**{name: scale * of_it[name].astype(float) for name in NUMBERS})
        _draw(axes, scaled, np.array([names.index(name) for name in of_it["name"]]))
        axes.set_title(f"${SYMBOLS.get(parameter, parameter)}$ [{unit}]")
        axes.tick_params(axis="y", labelleft=k % COLUMNS == 0, length=0)
    if first is not None:
        failed = {*table["name"][table["parameter"].isna()]}
        shown = range(0, len(names), -(-len(names) // NAMED))  # of many drives only some
        labels = [f"{name} (failed)" if name in failed else name for name in names]
        first.set_ylim(len(names) - 0.3, -0.7)
        first.set_yticks(list(shown), [labels[k] for k in shown])
    figure.legend(handles=_legend(learned), loc="outside lower center", ncols=4)
    return figure


def _draw(axes: Axes, table: pd.DataFrame, line: Array) -> None:
    """Draw the values of one parameter (n,) on the lines (n,) of their drives."""
    value = table["value"].to_numpy(float)
    low, high = _range(table)
    if low > 0.0 and high > DECADES * low:
        axes.set_xscale("log")
        style.log_ticks(axes.xaxis, low, high)
        low, high = low / (high / low) ** ROOM, high * (high / low) ** ROOM
    else:
        room = ROOM * (high - low) or 0.1 * abs(high) or 1.0
        low, high = low - room, high + room
        axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.set_xlim(low, high)
    axes.grid(axis="y")
    for level, (colour, inside, width) in LOOKS.items():
        of = (table["identifiability"] == level).to_numpy()
        gaps = np.full(of.sum(), np.nan)
        ends = np.column_stack([table.loc[of, ["low", "high"]].to_numpy(float), gaps])
        axes.plot(ends.ravel(), np.repeat(line[of], 3), color=colour, lw=width)
        (dots,) = axes.plot(value[of], line[of], "o", color=colour, mfc=inside, ms=3.2)
        name_points(dots, table.loc[of, "name"])


def _range(table: pd.DataFrame) -> tuple[float, float]:
    """Return the least and the greatest of what a panel must show."""
    seen = table[table["identifiability"] != NOT_IDENTIFIABLE]
    shown = table[["value"]] if seen.empty else seen[["low", "high", "value"]]
    values = shown.to_numpy(float).ravel()
    values = values[np.isfinite(values)]
    return float(values.min()), float(values.max())


def _legend(table: pd.DataFrame) -> list[Line2D]:
    return [
        Line2D([], [], color=colour, marker="o", ms=3.2, mfc=inside, lw=width, label=level)
        for level, (colour, inside, width) in reversed(LOOKS.items())
        if (table["identifiability"] == level).any()
    ]
