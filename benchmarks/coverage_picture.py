"""Intervals of learned parameters about the truth, those that miss it in another colour."""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullLocator

from stickslip.report.quantity import MEANINGS, number
from stickslip.report.style import (
    GREY,
    PAGE,
    RESOLUTION,
    THIN,
    WITH,
    WITHOUT,
    house_style,
    new_figure,
)

EVEN = 3.0
"""Median half-widths up to which the axis is linear; beyond it is logarithmic."""


def draw(table: pd.DataFrame) -> bytes:
    """Return a PNG file: a panel for each parameter, a line for each recording."""
    names = list(dict.fromkeys(table["parameter"]))
    with house_style():
        figure = new_figure(PAGE, 32.0 * len(names))
        panels = figure.subplots(len(names), 1, sharex=True, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=True):
            _panel(axes, table[table["parameter"] == name], name)
        panels[-1].set_xlabel("Recording")
        figure.align_ylabels()
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return stream.getvalue()


def _panel(axes: Axes, rows: pd.DataFrame, name: str) -> None:
    truth = rows["truth"].to_numpy()
    low, value, high = (
        100.0 * (rows[column].to_numpy() / truth - 1.0) for column in ("low", "value", "high")
    )
    k, holds = np.arange(1, len(rows) + 1), rows["holds"].to_numpy(dtype=bool)
    even = EVEN * float(np.median(0.5 * (high - low)))
    limit = max(even, 1.2 * float(np.max(np.abs([low, high]))))
    axes.axhline(0.0, color=GREY, lw=THIN)
    for part, colour in ((holds, WITH), (~holds, WITHOUT)):
        axes.vlines(k[part], low[part], high[part], color=colour, lw=1.2)
        axes.plot(k[part], value[part], "o", ms=2.0, color=colour)
    axes.set_yscale("symlog", linthresh=even, linscale=2.0)
    axes.set_ylim(-limit, limit)
    axes.set_yticks([-limit / 1.2, -0.6 * even, 0.0, 0.6 * even, limit / 1.2])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda x, _: number(x, 2)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_xlim(0.0, len(rows) + 1.0)
    axes.xaxis.get_major_locator().set_params(integer=True)
    said = MEANINGS[name]
    axes.set_ylabel("Error [%]")
    axes.set_title(f"{said[0].upper()}{said[1:]}: {holds.sum()} of {len(rows)} hold the truth")
