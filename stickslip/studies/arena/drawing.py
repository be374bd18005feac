"""The figures of arena.html."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, NullLocator

from stickslip.presentation import style
from stickslip.presentation.interactive import name_points
from stickslip.presentation.quantity import number


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
        few = high > 30.0 * low
        if high < 1.5 * low:
            axis.set_major_locator(MaxNLocator(4))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(NullLocator())
            continue
        axis.set_major_locator(LogLocator(subs=(1.0,) if few else (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


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
