"""What the learned drive leaves unexplained: position of the closed loop, or force."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.identification.criteria.motion import position_of
from stickslip.identification.estimation import Estimation
from stickslip.report.learned.parts import measures_friction, parts
from stickslip.report.learned.scales import (
    WORDS,
    Scale,
    force_scale,
    from_start,
    position_scale,
    velocity_scale,
)
from stickslip.report.learned.thinning import spread, thinned
from stickslip.report.quantity import number
from stickslip.report.style import (
    FAINT,
    GREY,
    INK,
    PAGE,
    THIN,
    WITH,
    name_panel,
    new_figure,
)
from stickslip.servo.measurement import Array

POINTS = 5000


def draw(estimation: Estimation) -> Figure:
    """Draw the residual over time, and over position and velocity."""
    recording, simulated = estimation.recording, estimation.figures.simulated
    place, push = WORDS[recording.motion]
    figure = new_figure(PAGE, 115.0)
    grid = figure.add_gridspec(2, 2)
    over_time = figure.add_subplot(grid[0, :])
    if simulated is None:
        inverse = parts(estimation)
        t, x, v, left = inverse.t, inverse.position, inverse.velocity, inverse.difference
        scale, what = force_scale(recording.motion, left), push.capitalize()
        if measures_friction(estimation):
            what = "Friction"
        name_panel(over_time, "a", f"{what}, recorded less implied")
    else:
        t, x, v = recording.t, position_of(recording), estimation.figures.velocity_recorded
        left = x - simulated
        scale, what = position_scale(recording.motion, left), place.capitalize()
        name_panel(over_time, "a", f"{what} in closed loop, recorded less simulated")
    over_time.axhline(0.0, color=GREY, lw=THIN)
    over_time.plot(*thinned(t, scale.factor * left), color=WITH, lw=0.5)
    over_time.set(xlabel="Time [s]", ylabel=f"{what} difference [{scale.unit}]", xlim=t[[0, -1]])
    if simulated is not None and recording.encoder_step > 0.0:
        _step(over_time, recording.encoder_step, scale)
    over_x, over_v = (figure.add_subplot(grid[1, k]) for k in (0, 1))
    x = from_start(x)
    _over(over_x, x, left, position_scale(recording.motion, x), scale, place.capitalize(), what)
    name_panel(over_x, "b", f"The same over {place}")
    _over(over_v, v, left, velocity_scale(recording.motion, v), scale, "Velocity", what)
    name_panel(over_v, "c", "The same over velocity")
    return figure


def _step(axes: Axes, step: float, scale: Scale) -> None:
    """Shade one step of the encoder."""
    half = 0.5 * scale.factor * step
    said = f"one step of the encoder, {number(2 * half, 3)} {scale.unit}"
    axes.axhspan(-half, half, color=INK, alpha=0.15, lw=0, zorder=3, label=said)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -1.5 * half), max(high + 0.25 * (high - low), 2.0 * half))
    axes.legend(loc="upper right")


def _over(
    axes: Axes, x: Array, left: Array, x_scale: Scale, scale: Scale, said: str, what: str
) -> None:
    few = spread(len(x), POINTS)
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.plot(
        x_scale.factor * x[few], scale.factor * left[few], ".", ms=1.5, mew=0, color=WITH,
        alpha=0.5, rasterized=True,
    )  # fmt: skip
    axes.set(xlabel=f"{said} [{x_scale.unit}]", ylabel=f"{what} difference [{scale.unit}]")
