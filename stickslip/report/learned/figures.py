"""Figures of what one recording gave: the recording, the force, and the residual."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from stickslip.identification.criteria.motion import measured_force, position_of
from stickslip.identification.estimation import Estimation
from stickslip.report.learned.scales import (
    WORDS,
    Scale,
    force_scale,
    from_start,
    position_scale,
    velocity_scale,
)
from stickslip.report.learned.signals import (
    Parts,
    measures_friction,
    parts,
    sliding,
    spread,
    stribeck,
    thinned,
)
from stickslip.report.quantity import number, percent
from stickslip.report.style import (
    FAINT,
    GREY,
    INK,
    PAGE,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)
from stickslip.servo.measurement import Array

DASHED = (0, (4, 2))


def draw_recording(estimation: Estimation) -> Figure:
    """Draw the signals over time, commands dashed."""
    recording, t = estimation.recording, estimation.recording.t
    recorded, velocity = position_of(recording), estimation.figures.velocity_recorded
    position = from_start(recorded)
    command = recording.position_command
    if command is not None:
        command = command - (recorded[0] - position[0])
    place, push = WORDS[recording.motion]
    figure = new_figure(PAGE, 115.0)
    panels = figure.subplots(3, 1, sharex=True)
    where = place.capitalize()
    if recording.position is None:
        where += ", integrated from the velocity"
    elif position is not recorded:
        where += ", from its first value on"
    _signal(
        panels[0], "a", where, t, position, command,
        position_scale(recording.motion, position),
    )  # fmt: skip
    _signal(
        panels[1], "b", "Velocity, low-passed", t, velocity, recording.velocity_command,
        velocity_scale(recording.motion, velocity),
    )  # fmt: skip
    force = measured_force(recording)
    title = "Measured friction" if measures_friction(estimation) else f"Motor {push}"
    _signal(panels[2], "c", title, t, force, None, force_scale(recording.motion, force), INK)
    panels[2].set(xlabel="Time [s]", xlim=(t[0], t[-1]))
    figure.align_ylabels()
    return figure


def _signal(
    axes: Axes,
    letter: str,
    title: str,
    t: Array,
    signal: Array,
    command: Array | None,
    scale: Scale,
    colour: str = WITH,
) -> None:
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.plot(*thinned(t, scale.factor * signal), color=colour, lw=0.8, label="recorded")
    if command is not None:
        axes.plot(
            *thinned(t, scale.factor * command), color=WITHOUT, lw=0.8, ls=DASHED, label="command"
        )
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.28 * (high - low))
        axes.legend(loc="upper right", ncols=2)
    axes.set_ylabel(f"{title.split(',')[0].split()[-1].capitalize()} [{scale.unit}]")
    name_panel(axes, letter, title)


CLOUD_POINTS = 6000


def draw_force(estimation: Estimation) -> Figure:
    """Draw force over time, its difference, and friction over velocity."""
    if measures_friction(estimation):
        return _draw_hysteresis(estimation)
    signals = parts(estimation)
    figure = new_figure(PAGE, 125.0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.35, 1.0))
    left, right = (grid[0, k].subgridspec(2, 1) for k in (0, 1))
    upper = figure.add_subplot(left[0])
    lower = figure.add_subplot(left[1], sharex=upper)
    upper.tick_params(labelbottom=False)
    _force_over_time(upper, lower, estimation, signals)
    magnitude = figure.add_subplot(right[1])
    _friction(figure.add_subplot(right[0]), magnitude, estimation, signals)
    figure.align_ylabels((upper, lower))
    handles, labels = magnitude.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower right", ncols=3, markerscale=4.0)
    return figure


def _force_over_time(upper: Axes, lower: Axes, estimation: Estimation, signals: Parts) -> None:
    """Draw recorded and predicted force over time, and their difference below."""
    motion = estimation.recording.motion
    scale, fine = force_scale(motion, signals.measured), force_scale(motion, signals.difference)
    upper.axhline(0.0, color=FAINT, lw=THIN)
    force = scale.factor * signals.measured
    upper.plot(*thinned(signals.t, force), color=WITHOUT, lw=1.6, alpha=0.7, label="recorded")
    predicted = scale.factor * signals.predicted
    upper.plot(
        *thinned(signals.t, predicted), color=WITH, lw=0.6, label="predicted by the learned drive"
    )
    low, high = upper.get_ylim()
    upper.set_ylim(low, high + 0.2 * (high - low))
    upper.legend(loc="upper right", ncols=2)
    push = WORDS[motion][1].capitalize()
    upper.set_ylabel(f"{push} [{scale.unit}]")
    name_panel(upper, "a", f"{push}, relative error {percent(estimation.figures.force)}")
    lower.axhline(0.0, color=GREY, lw=THIN)
    lower.plot(*thinned(signals.t, fine.factor * signals.difference), color=WITH, lw=0.5)
    lower.set(xlabel="Time [s]", ylabel=f"Difference [{fine.unit}]", xlim=signals.t[[0, -1]])
    name_panel(lower, "b", "Recorded less predicted")


def _friction(both: Axes, magnitude: Axes, estimation: Estimation, signals: Parts) -> None:
    """Draw friction over velocity, and its absolute value over the logarithm of speed."""
    motion = estimation.recording.motion
    v, friction = signals.velocity, signals.measured - signals.rest
    steady = sliding(estimation, signals)
    top = float(np.max(np.abs(v)))
    speed = np.geomspace(1e-4 * top, top, 300)
    curve = stribeck(estimation, np.concatenate([-speed[::-1], speed]))
    highest = max(
        np.max(np.abs(curve)), np.quantile(np.abs(friction[steady]), 0.999) if steady.any() else 0.0
    )
    v_scale, scale = velocity_scale(motion, v), force_scale(motion, curve)
    few = spread(len(v), CLOUD_POINTS)
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
    name_panel(magnitude, "d", "Friction against speed")


LOOP_POINTS = 8000


def _draw_hysteresis(estimation: Estimation) -> Figure:
    """Draw the loops, friction over time, and the difference."""
    signals = parts(estimation)
    figure = new_figure(PAGE, 115.0)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.15))
    _loops(figure.add_subplot(grid[:, 0]), estimation, signals)
    upper = figure.add_subplot(grid[0, 1])
    lower = figure.add_subplot(grid[1, 1], sharex=upper)
    upper.tick_params(labelbottom=False)
    _friction_over_time(upper, lower, estimation, signals)
    figure.align_ylabels((upper, lower))
    return figure


def _loops(axes: Axes, estimation: Estimation, signals: Parts) -> None:
    motion = estimation.recording.motion
    scale = force_scale(motion, signals.measured)
    x = from_start(signals.position)
    x_scale = position_scale(motion, x)
    few = spread(len(x), LOOP_POINTS)
    axes.axhline(0.0, color=FAINT, lw=THIN)
    for force, colour, width, label in (
        (signals.measured, WITHOUT, 0.5, "recorded"),
        (signals.predicted, WITH, 0.5, "learned"),
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


def _friction_over_time(upper: Axes, lower: Axes, estimation: Estimation, signals: Parts) -> None:
    motion = estimation.recording.motion
    scale, fine = force_scale(motion, signals.measured), force_scale(motion, signals.difference)
    upper.axhline(0.0, color=FAINT, lw=THIN)
    upper.plot(
        *thinned(signals.t, scale.factor * signals.measured), color=WITHOUT, lw=1.4, alpha=0.7
    )
    upper.plot(*thinned(signals.t, scale.factor * signals.predicted), color=WITH, lw=0.6)
    upper.set_ylabel(f"Friction [{scale.unit}]")
    name_panel(upper, "b", "Friction over time")
    lower.axhline(0.0, color=GREY, lw=THIN)
    lower.plot(*thinned(signals.t, fine.factor * signals.difference), color=WITH, lw=0.5)
    lower.set(xlabel="Time [s]", ylabel=f"Difference [{fine.unit}]", xlim=signals.t[[0, -1]])
    name_panel(lower, "c", "Recorded less learned")


RESIDUAL_POINTS = 5000


def draw_residual(estimation: Estimation) -> Figure:
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
        name_panel(over_time, "a", f"{what}, recorded less predicted")
    else:
        t, x, v = recording.t, position_of(recording), estimation.figures.velocity_recorded
        left = x - simulated
        scale, what = position_scale(recording.motion, left), place.capitalize()
        name_panel(over_time, "a", f"{what} in closed loop, recorded less simulated")
    over_time.axhline(0.0, color=GREY, lw=THIN)
    over_time.plot(*thinned(t, scale.factor * left), color=WITH, lw=0.5)
    over_time.set(xlabel="Time [s]", ylabel=f"{what} difference [{scale.unit}]", xlim=t[[0, -1]])
    if simulated is not None and recording.encoder_step > 0.0:
        _encoder_step(over_time, recording.encoder_step, scale)
    over_x, over_v = (figure.add_subplot(grid[1, k]) for k in (0, 1))
    x = from_start(x)
    _over(over_x, x, left, position_scale(recording.motion, x), scale, place.capitalize(), what)
    name_panel(over_x, "b", f"The same over {place}")
    _over(over_v, v, left, velocity_scale(recording.motion, v), scale, "Velocity", what)
    name_panel(over_v, "c", "The same over velocity")
    return figure


def _encoder_step(axes: Axes, step: float, scale: Scale) -> None:
    """Shade one step of the encoder."""
    half = 0.5 * scale.factor * step
    label = f"one step of the encoder, {number(2 * half, 3)} {scale.unit}"
    axes.axhspan(-half, half, color=INK, alpha=0.15, lw=0, zorder=3, label=label)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -1.5 * half), max(high + 0.25 * (high - low), 2.0 * half))
    axes.legend(loc="upper right")


def _over(
    axes: Axes, x: Array, left: Array, x_scale: Scale, scale: Scale, label: str, what: str
) -> None:
    few = spread(len(x), RESIDUAL_POINTS)
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.plot(
        x_scale.factor * x[few], scale.factor * left[few], ".", ms=1.5, mew=0, color=WITH,
        alpha=0.5, rasterized=True,
    )  # fmt: skip
    axes.set(xlabel=f"{label} [{x_scale.unit}]", ylabel=f"{what} difference [{scale.unit}]")
