"""The recorded force against the one that the learned drive implies, and friction over velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from stickslip.identification.estimation import Estimation
from stickslip.report.learned import hysteresis_picture
from stickslip.report.learned.parts import (
    Parts,
    measures_friction,
    parts,
    sliding,
    stribeck,
)
from stickslip.report.learned.scales import (
    WORDS,
    force_scale,
    velocity_scale,
)
from stickslip.report.learned.thinning import spread, thinned
from stickslip.report.quantity import percent
from stickslip.report.style import (
    FAINT,
    GREY,
    PAGE,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)

POINTS = 6000


def draw(estimation: Estimation) -> Figure:
    """Draw force over time, its difference, and friction over velocity."""
    if measures_friction(estimation):
        return hysteresis_picture.draw(estimation)
    shown = parts(estimation)
    figure = new_figure(PAGE, 125.0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.35, 1.0))
    left, right = (grid[0, k].subgridspec(2, 1) for k in (0, 1))
    upper = figure.add_subplot(left[0])
    lower = figure.add_subplot(left[1], sharex=upper)
    upper.tick_params(labelbottom=False)
    _force(upper, lower, estimation, shown)
    magnitude = figure.add_subplot(right[1])
    _friction(figure.add_subplot(right[0]), magnitude, estimation, shown)
    figure.align_ylabels((upper, lower))
    handles, labels = magnitude.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower right", ncols=3, markerscale=4.0)
    return figure


def _force(upper: Axes, lower: Axes, estimation: Estimation, shown: Parts) -> None:
    """Draw recorded and implied force over time, and below it what is left."""
    motion = estimation.recording.motion
    scale, fine = force_scale(motion, shown.shown), force_scale(motion, shown.difference)
    upper.axhline(0.0, color=FAINT, lw=THIN)
    force = scale.factor * shown.shown
    upper.plot(*thinned(shown.t, force), color=WITHOUT, lw=1.6, alpha=0.7, label="recorded")
    implied = scale.factor * shown.implied
    upper.plot(*thinned(shown.t, implied), color=WITH, lw=0.6, label="implied by the learned drive")
    low, high = upper.get_ylim()
    upper.set_ylim(low, high + 0.2 * (high - low))
    upper.legend(loc="upper right", ncols=2)
    push = WORDS[motion][1].capitalize()
    upper.set_ylabel(f"{push} [{scale.unit}]")
    name_panel(upper, "a", f"{push}, relative error {percent(estimation.figures.force)}")
    lower.axhline(0.0, color=GREY, lw=THIN)
    lower.plot(*thinned(shown.t, fine.factor * shown.difference), color=WITH, lw=0.5)
    lower.set(xlabel="Time [s]", ylabel=f"Difference [{fine.unit}]", xlim=shown.t[[0, -1]])
    name_panel(lower, "b", "Recorded less implied")


def _friction(both: Axes, magnitude: Axes, estimation: Estimation, shown: Parts) -> None:
    """Draw friction over velocity, and its magnitude over the logarithm of speed."""
    motion = estimation.recording.motion
    v, friction = shown.velocity, shown.shown - shown.rest
    steady = sliding(estimation, shown)
    top = float(np.max(np.abs(v)))
    speed = np.geomspace(1e-4 * top, top, 300)
    curve = stribeck(estimation, np.concatenate([-speed[::-1], speed]))
    highest = max(
        np.max(np.abs(curve)), np.quantile(np.abs(friction[steady]), 0.999) if steady.any() else 0.0
    )
    v_scale, scale = velocity_scale(motion, v), force_scale(motion, curve)
    few = spread(len(v), POINTS)
    clouds = (
        (few[~steady[few]], FAINT, "recorded, soon after a reversal"),
        (few[steady[few]], WITHOUT, "recorded, sliding"),
    )
    for rows, colour, label in clouds:
        x, y = v_scale.factor * v[rows], scale.factor * friction[rows]
        style: dict[str, Any] = {"ms": 2.0, "mew": 0, "color": colour, "rasterized": True}
        both.plot(x, y, ".", **style)
        magnitude.plot(np.abs(x), y * np.sign(x), ".", label=label, **style)
    x = v_scale.factor * speed
    for sign, half in ((-1.0, curve[:300][::-1]), (1.0, curve[300:])):
        both.plot(sign * x, scale.factor * half, color=WITH)
    magnitude.plot(x, scale.factor * curve[300:], color=WITH, label="learned Stribeck curve")
    limit = 1.15 * scale.factor * float(highest)
    both.set(ylim=(-limit, limit), xlabel=f"Velocity [{v_scale.unit}]")
    magnitude.set_xscale("log")
    magnitude.set(
        xlim=(x[0], 1.1 * x[-1]), ylim=(0.0, limit),
        xlabel=f"Speed [{v_scale.unit}], logarithmic",
    )  # fmt: skip
    for axes in (both, magnitude):
        axes.axhline(0.0, color=FAINT, lw=THIN)
        axes.set_ylabel(f"Friction [{scale.unit}]")
    both.axvline(0.0, color=FAINT, lw=THIN)
    magnitude.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    name_panel(both, "c", "Friction over velocity")
    name_panel(magnitude, "d", "Its magnitude over speed")
