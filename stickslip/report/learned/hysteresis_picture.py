"""Measured friction: its loops over position, recorded and learned."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.identification.estimation import Estimation
from stickslip.report.learned.parts import Parts, parts
from stickslip.report.learned.scales import (
    WORDS,
    force_scale,
    from_start,
    position_scale,
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

POINTS = 8000


def draw(estimation: Estimation) -> Figure:
    """Draw the loops, friction over time, and what is left of it."""
    shown = parts(estimation)
    figure = new_figure(PAGE, 115.0)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.15))
    _loops(figure.add_subplot(grid[:, 0]), estimation, shown)
    upper = figure.add_subplot(grid[0, 1])
    lower = figure.add_subplot(grid[1, 1], sharex=upper)
    upper.tick_params(labelbottom=False)
    _course(upper, lower, estimation, shown)
    figure.align_ylabels((upper, lower))
    return figure


def _loops(axes: Axes, estimation: Estimation, shown: Parts) -> None:
    motion = estimation.recording.motion
    scale = force_scale(motion, shown.shown)
    x = from_start(shown.position)
    x_scale = position_scale(motion, x)
    few = spread(len(x), POINTS)
    axes.axhline(0.0, color=FAINT, lw=THIN)
    for force, colour, width, label in (
        (shown.shown, WITHOUT, 0.5, "recorded"),
        (shown.implied, WITH, 0.5, "learned"),
    ):
        axes.plot(
            x_scale.factor * x[few], scale.factor * force[few], color=colour, lw=width,
            label=label, rasterized=True,
        )  # fmt: skip
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.12 * (high - low))
    legend = axes.legend(loc="upper left", ncols=2)
    for line in legend.get_lines():
        line.set_linewidth(1.5)
    place = WORDS[motion][0].capitalize()
    axes.set(xlabel=f"{place} [{x_scale.unit}]", ylabel=f"Friction [{scale.unit}]")
    error = percent(estimation.figures.force)
    name_panel(axes, "a", f"Hysteresis, relative error {error}")


def _course(upper: Axes, lower: Axes, estimation: Estimation, shown: Parts) -> None:
    motion = estimation.recording.motion
    scale, fine = force_scale(motion, shown.shown), force_scale(motion, shown.difference)
    upper.axhline(0.0, color=FAINT, lw=THIN)
    upper.plot(*thinned(shown.t, scale.factor * shown.shown), color=WITHOUT, lw=1.4, alpha=0.7)
    upper.plot(*thinned(shown.t, scale.factor * shown.implied), color=WITH, lw=0.6)
    upper.set_ylabel(f"Friction [{scale.unit}]")
    name_panel(upper, "b", "Friction over time")
    lower.axhline(0.0, color=GREY, lw=THIN)
    lower.plot(*thinned(shown.t, fine.factor * shown.difference), color=WITH, lw=0.5)
    lower.set(xlabel="Time [s]", ylabel=f"Difference [{fine.unit}]", xlim=shown.t[[0, -1]])
    name_panel(lower, "c", "Recorded less learned")
