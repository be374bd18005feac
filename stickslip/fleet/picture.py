"""What a fleet looks like: a panel for each parameter, a line for each drive."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from stickslip.fleet.table import SIMULATED
from stickslip.identification.fitting.identifiability import (
    IDENTIFIABLE,
    NOT_IDENTIFIABLE,
    WEAKLY_IDENTIFIABLE,
)
from stickslip.report.style import (
    GREY,
    INK,
    LINE,
    PAGE,
    RESOLUTION,
    THIN,
    WITH,
    WITHOUT,
    house_style,
    new_figure,
)
from stickslip.servo.measurement import Array

LOOKS = {
    NOT_IDENTIFIABLE: (GREY, "white", THIN),
    WEAKLY_IDENTIFIABLE: (WITHOUT, WITHOUT, LINE),
    IDENTIFIABLE: (WITH, WITH, LINE),
}
"""Colour of the line and of the inside of the dot, and width of the line [pt]."""
NUMBERS = ("value", "low", "high", "truth")
SYMBOLS = {"sigma_0": r"\sigma_0", "sigma_1": r"\sigma_1"}
SCALES = {
    ("v_s", "m/s"): (1e3, "mm/s"),
    ("v_s", "rad/s"): (1e3, "mrad/s"),
    ("sigma_0", "N/m"): (1e-6, "N/µm"),
    ("sigma_0", "N.m/rad"): (1e-3, "N m/mrad"),
    ("sigma_1", "N.s/m"): (1e-3, "N s/mm"),
}
"""Factors to units in which numbers are short; other units stay."""
COLUMNS = 4
PITCH = 4.2
"""From one drive's line to the next, where there is room [mm]."""
NAMED = 40
"""So many lines can be named; of more drives only some are."""
DECADES = 3.0
"""A panel whose values differ by more than this factor is logarithmic."""
ROOM = 0.12
"""Left free beside the outermost values, as a share of their range."""
LONGEST = 190.0
"""Of all lines of a panel [mm]."""


def draw_fleet(table: pd.DataFrame) -> dict[str, bytes]:
    """Return the figure of a fleet's table by kind of file, ``png`` and ``svg``.

    Values stand with their 95 % intervals; the truth of variants is a bar. What is not identifiable
    does not set the range of its panel. Drives that failed keep an empty line.
    """
    files = {"png": io.BytesIO(), "svg": io.BytesIO()}
    with house_style():
        figure = _figure(table)
        figure.savefig(files["png"], format="png", dpi=RESOLUTION, metadata={"Software": None})
        figure.savefig(files["svg"], format="svg", metadata={"Date": None, "Creator": None})
    return {kind: stream.getvalue() for kind, stream in files.items()}


def _figure(table: pd.DataFrame) -> Figure:
    names = list(dict.fromkeys(table["name"]))
    learned = table[table["parameter"].notna()]
    panels: list[tuple[Any, pd.DataFrame]] = list(
        learned.groupby(["parameter", "unit"], sort=False)
    )
    rows = -(-len(panels) // COLUMNS)
    height = min(max(PITCH * len(names), 12.0), LONGEST / rows)
    figure = new_figure(PAGE, 12.0 + rows * (height + 17.0))
    first: Axes | None = None
    for k, (key, of_it) in enumerate(panels):
        parameter, unit = key
        axes = figure.add_subplot(rows, COLUMNS, k + 1, sharey=first)
        first = first or axes
        scale, unit = SCALES.get((parameter, unit), (1.0, unit.replace(".", " ")))
        scaled = of_it.assign(**{name: scale * of_it[name].astype(float) for name in NUMBERS})
        _draw(axes, scaled, np.array([names.index(name) for name in of_it["name"]]))
        axes.set_title(f"${SYMBOLS.get(parameter, parameter)}$ [{unit}]")
        axes.tick_params(axis="y", labelleft=k % COLUMNS == 0, length=0)
    if first is not None:
        remarks = dict.fromkeys(table["name"][table["source"] == SIMULATED], "simulated")
        remarks |= dict.fromkeys(table["name"][table["parameter"].isna()], "failed")
        _name_drives(first, names, remarks)
    figure.legend(handles=_legend(learned), loc="outside lower center", ncols=4)
    return figure


def _draw(axes: Axes, table: pd.DataFrame, line: Array) -> None:
    """Draw the values of one parameter (n,) on the lines (n,) of their drives."""
    value, truth = table["value"].to_numpy(float), table["truth"].to_numpy(float)
    low, high = _range(table)
    if low > 0.0 and high > DECADES * low:
        axes.set_xscale("log")
        few = high > 30.0 * low
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if few else (1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        low, high = low / (high / low) ** ROOM, high * (high / low) ** ROOM
    else:
        room = ROOM * (high - low) or 0.1 * abs(high) or 1.0
        low, high = low - room, high + room
        axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.set_xlim(low, high)
    axes.grid(axis="y")
    for level, (colour, inside, width) in LOOKS.items():
        of = (table["identifiability"] == level).to_numpy()
        ends = table["low"].to_numpy(float)[of], table["high"].to_numpy(float)[of]
        axes.hlines(line[of], *ends, color=colour, lw=width)
        axes.plot(value[of], line[of], "o", color=colour, mfc=inside, ms=3.2)
    axes.plot(truth, line, "|", color=INK, ms=8.0, mew=0.8, zorder=1)


def _range(table: pd.DataFrame) -> tuple[float, float]:
    """Return the least and the greatest of what a panel must show."""
    seen = table[table["identifiability"] != NOT_IDENTIFIABLE]
    shown = [table["truth"], seen["low"], seen["high"], seen["value"]]
    if seen.empty:
        shown.append(table["value"])
    values = pd.concat(shown).to_numpy(float)
    values = values[np.isfinite(values)]
    return float(values.min()), float(values.max())


def _name_drives(axes: Axes, names: list[str], remarks: dict[str, str]) -> None:
    """Name the lines; of many drives only some."""
    axes.set_ylim(len(names) - 0.3, -0.7)
    shown = range(0, len(names), -(-len(names) // NAMED))
    labels = [
        f"{names[k]} ({remarks[names[k]]})" if names[k] in remarks else names[k] for k in shown
    ]
    axes.set_yticks(list(shown), labels)


def _legend(table: pd.DataFrame) -> list[Line2D]:
    handles = [
        Line2D([], [], color=colour, marker="o", ms=3.2, mfc=inside, lw=width, label=level)
        for level, (colour, inside, width) in reversed(LOOKS.items())
        if (table["identifiability"] == level).any()
    ]
    if table["truth"].notna().any():
        mark = Line2D([], [], color=INK, marker="|", ms=8.0, mew=0.8, ls="", label="truth")
        handles.append(mark)
    return handles
