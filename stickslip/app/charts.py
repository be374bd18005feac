"""Options of ECharts for signals and for the course of a search."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

import stickslip as ss

Options = dict[str, Any]
MOST = 800  # points of a signal that are drawn
COLOURS = ["#2f7fb8", "#e07b00", "#3a9a5b", "#9a6fb8", "#c9503c", "#7a7f87"]
INK, LINE = "#868b92", "#868b9255"  # legible on light and dark

NUMBER = "v => isNaN(v) || !v || (1e-3 <= Math.abs(v) && Math.abs(v) < 1e5) ? v : v.toExponential()"
LABEL = {"color": INK, "hideOverlap": True, ":formatter": NUMBER}


def _axis(name: str, **more: Any) -> Options:
    return {
        "name": name,
        "nameLocation": "middle",
        "nameGap": 26,
        "nameTextStyle": {"color": INK},
        "axisLabel": LABEL,
        "axisLine": {"lineStyle": {"color": LINE}},
        "splitLine": {"lineStyle": {"color": LINE}},
        **more,
    }


def _chart(**more: Any) -> Options:
    grid = {"left": 64, "right": 20, "top": 34, "bottom": 42}
    return {"animation": False, "color": COLOURS, "grid": grid, "tooltip": {}, **more}


def thinned(values: np.ndarray, most: int = MOST) -> np.ndarray:
    """Return the places of some samples (n,) that keep the extremes of each stretch."""
    n = len(values)
    if n <= most:
        return np.arange(n)
    edges = np.linspace(0, n, most // 2 + 1).astype(int)
    ends = [
        begin + place
        for begin, end in pairwise(edges)
        for place in sorted({int(np.argmin(values[begin:end])), int(np.argmax(values[begin:end]))})
    ]
    return np.array(sorted({*ends, n - 1}))


def signals(of: Mapping[str, Any], before: Any = None) -> Options:
    """Draw pairs of times and values by name, and one ``before``, which is dashed."""
    pale = {"width": 1.2, "type": "dashed", "opacity": 0.6}
    drawn = [("", before, pale)] if before else []
    drawn += [(name, pair, {"width": 1.4}) for name, pair in of.items()]
    series = []
    for k, (name, (time, values), style) in enumerate(drawn):
        at, colour = thinned(values), {"color": COLOURS[max(k - len(drawn) + len(of), 0) % 6]}
        look = {"type": "line", "showSymbol": False, "itemStyle": colour, "lineStyle": style}
        series.append({**look, "name": name, "data": _points(time[at], values[at])})
    return _chart(
        xAxis=_axis("time [s]", type="value", max="dataMax", min="dataMin"),
        yAxis=_axis("", type="value", scale=True),
        series=series,
        dataZoom=[{"type": "inside"}],
        grid={"left": 64, "right": 20, "top": 10, "bottom": 42},
        tooltip={"trigger": "axis"},
    )


def _points(x: np.ndarray, y: np.ndarray) -> list[list[float | None]]:
    return [
        [float(f"{a:.6g}"), float(f"{b:.5g}") if np.isfinite(b) else None]
        for a, b in zip(x, y, strict=True)
    ]


def history(table: pd.DataFrame) -> Options:
    """Draw the cost of each candidate of a search, and the lowest so far."""
    cost = table["cost"].to_numpy(float)
    places = np.arange(1.0, len(cost) + 1.0)
    cost = np.where(cost > 0.0, cost, np.nan)
    best = np.fmin.accumulate(np.where(np.isfinite(cost), cost, np.nan))
    dots = {"type": "scatter", "symbolSize": 5, "itemStyle": {"opacity": 0.55}}
    line = {"type": "line", "step": "end", "showSymbol": False}
    return _chart(
        xAxis=_axis("candidate", type="value"),
        yAxis=_axis("", type="log"),
        series=[
            {**dots, "name": "cost", "data": _points(places, cost)},
            {**line, "name": "lowest so far", "data": _points(places, best)},
        ],
        legend={"top": 0, "textStyle": {"color": INK}},
    )


def parallel(table: pd.DataFrame, names: list[str]) -> Options:
    """Draw each candidate as a line through its parameters, coloured by the rank of its cost."""
    shown = table[np.isfinite(table["cost"])].nsmallest(200, "cost").iloc[::-1]
    rank = np.linspace(1.0, 0.0, len(shown))
    axes = [
        {
            "dim": k,
            "name": name.replace(".", "\n"),
            "nameTextStyle": {"color": INK, "lineHeight": 14},
            "scale": True,
            "type": "log" if 0.0 < 30.0 * shown[name].min() < shown[name].max() else "value",
            "axisLabel": LABEL,
            "axisLine": {"lineStyle": {"color": INK}},
        }
        for k, name in enumerate([*names, "cost"])
    ]
    rows = [
        [*(float(f"{value:.5g}") for value in row), float(f"{place:.3g}")]
        for row, place in zip(shown[[*names, "cost"]].to_numpy(float), rank, strict=True)
    ]
    colour = {"color": [COLOURS[1], "#9fb4c2"]}
    scale = {"show": False, "min": 0, "max": 1, "dimension": len(names) + 1, "inRange": colour}
    return _chart(
        parallelAxis=axes,
        parallel={"left": 60, "right": 70, "top": 46, "bottom": 24},
        visualMap=scale,
        series=[{"type": "parallel", "lineStyle": {"width": 1.2, "opacity": 0.6}, "data": rows}],
    )


def importances(table: pd.DataFrame, names: list[str]) -> Options:
    """Draw the share of the cost's variance that each parameter explains alone."""
    shares = ss.ga.importances(table, names)
    order = list(shares)[::-1]
    bars = [float(f"{shares[name]:.3g}") for name in order]
    return _chart(
        xAxis=_axis("share of the variance of the cost's rank", type="value", min=0, max=1),
        yAxis=_axis("", type="category", data=order),
        series=[{"type": "bar", "data": bars, "barMaxWidth": 18}],
        grid={"left": 130, "right": 24, "top": 12, "bottom": 44},
    )
