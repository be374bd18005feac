"""Profile likelihoods: the loss of likelihood at each value of a parameter."""

from __future__ import annotations

import math
from string import ascii_lowercase

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator
from scipy.interpolate import PchipInterpolator

from stickslip.identification.estimation import Estimation
from stickslip.report import style
from stickslip.report.learned.scales import parameter_scale
from stickslip.report.quantity import meaning, number, symbol
from stickslip.report.style import GREY, SHADE, WITH, WITHOUT
from stickslip.servo.measurement import Array

LINE_95 = 3.84
"""Deviance at the ends of a 95 % interval."""
TOP = 10.0
WIDE = 3.0
"""Ratio of the ends beyond which an axis is logarithmic."""
FARTHEST = 1e3
"""Ratio to the fitted value beyond which nothing is drawn."""


def draw_profiles(estimation: Estimation) -> Figure:
    """Draw a panel for each parameter of friction, with its interval and the 95 % line."""
    names = estimation.fit.space.friction
    rows = len(names) // 3 + 1  # one panel more, for the legend
    figure = style.new_figure(style.PAGE, 52.5 * rows)
    panels = figure.subplots(rows, 3, sharey=True, squeeze=False).ravel()
    for axes, letter, name in zip(panels, ascii_lowercase, names, strict=False):
        _panel(axes, estimation, name)
        style.name_panel(axes, letter, f"{meaning(name)}, {estimation.known[name].visible}")
    for axes in panels[: len(names) : 3]:
        axes.set_ylabel("Deviance")
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    _legend(panels[-1])
    return figure


def _panel(axes: Axes, estimation: Estimation, name: str) -> None:
    known, fitted = estimation.known[name], estimation.known[name].value
    scale = parameter_scale(name, fitted, estimation.recording.motion, prefixed=True)
    value, deviance = _curve(estimation, name)
    drawn = _resolved(deviance)
    ends = (value[0], value[-1]) if drawn else (fitted / FARTHEST, fitted * FARTHEST)
    low, high = (np.clip(end, *ends) for end in (known.low, known.high))
    axes.axvspan(scale.factor * low, scale.factor * high, color=SHADE, lw=0)
    axes.axhline(LINE_95, color=GREY, lw=0.8, ls=style.DASHED)
    axes.axvline(scale.factor * fitted, color=WITHOUT, lw=0.8)
    axes.set_ylim(-0.3, TOP)
    if drawn:
        axes.plot(*_smooth(scale.factor * value, deviance, scale.factor * fitted), color=WITH)
        axes.plot(scale.factor * value, deviance, "o", color=WITH, ms=3.0)
    else:
        axes.text(
            0.5, 0.75, "profile not resolved", transform=axes.transAxes, ha="center", color=GREY,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 2.0},
        )  # fmt: skip

        value = np.array([low, high])
    _ticks(axes, scale.factor * value)
    axes.set_xlabel(f"{symbol(name)} [{scale.unit}]")


def unresolved(estimation: Estimation) -> list[str]:
    """Return the parameters whose profile is too steep to be one."""
    names = estimation.fit.space.friction
    return [name for name in names if not _resolved(_curve(estimation, name)[1])]


def _curve(estimation: Estimation, name: str) -> tuple[Array, Array]:
    """Return values and deviances of one parameter, without what is too far away to draw."""
    fitted = estimation.known[name].value
    rows = estimation.profiles[estimation.profiles["parameter"] == name]
    value, deviance = (rows[column].to_numpy(dtype=float) for column in ("value", "deviance"))
    near = (value > fitted / FARTHEST) & (value < fitted * FARTHEST)
    return value[near], deviance[near]


def _resolved(deviance: Array) -> bool:
    """Tell whether a profile is near 1 at one standard error, so that the others did follow."""
    if len(deviance) < 3:
        return False
    fitted = int(np.argmin(deviance))
    beside = [deviance[k] for k in (fitted - 1, fitted + 1) if 0 <= k < len(deviance)]
    return bool(min(beside) < LINE_95)


def _smooth(value: Array, deviance: Array, fitted: float) -> tuple[Array, Array]:
    """Return a curve through the points: the root of a parabola is a straight line."""
    root = np.sign(value - fitted) * np.sqrt(deviance)
    fine = np.geomspace(value[0], value[-1], 200)
    return fine, PchipInterpolator(np.log(value), root)(np.log(fine)) ** 2


def _ticks(axes: Axes, value: Array) -> None:
    """Put a few ticks on: powers of ten where decades are shown."""
    if value[-1] > WIDE * value[0]:
        axes.set_xscale("log")
        decades = np.arange(math.ceil(math.log10(value[0])), math.floor(math.log10(value[-1])) + 1)
        ticks = 10.0 ** decades[:: -(-len(decades) // 4) or 1]
        if len(ticks) < 2:
            ticks = np.geomspace(value[0], value[-1], 3)
        axes.xaxis.set_major_locator(FixedLocator([float(f"{tick:.1g}") for tick in ticks]))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: _tick(x)))
        return
    axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    axes.ticklabel_format(axis="x", useOffset=False, style="plain")


def _tick(x: float) -> str:
    if 1e-2 <= x < 1e4:
        return number(x, 2)
    return f"$10^{{{round(math.log10(x))}}}$"


def _legend(axes: Axes) -> None:
    handles = [
        Line2D([], [], color=WITH, marker="o", ms=3.0),
        Line2D([], [], color=WITHOUT, lw=0.8),
        Patch(color=SHADE),
        Line2D([], [], color=GREY, lw=0.8, ls=style.DASHED),
    ]
    labels = ["profile likelihood", "learned value", "95 % interval", "95 % level, 3.84"]
    axes.legend(handles, labels, loc="center left")
