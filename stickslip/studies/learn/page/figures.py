"""Figures of what one recording gave: recording, force, residual, and profile likelihoods."""

from collections.abc import Iterator
from string import ascii_lowercase
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import (
    FormatStrFormatter,
    MaxNLocator,
)
from scipy.interpolate import PchipInterpolator
from scipy.signal import welch

from stickslip.identification.criteria.motion import measured_force, position_of
from stickslip.identification.estimation import Estimation
from stickslip.presentation import style
from stickslip.presentation.interactive import keep
from stickslip.presentation.quantity import meaning, number, percent, symbol
from stickslip.presentation.scale import (
    COLUMNS,
    WORDS,
    Scale,
    force_scale,
    from_start,
    parameter_scale,
    position_scale,
    spread,
    thinned,
    velocity_scale,
)
from stickslip.presentation.style import GREY, SHADE, WITH, WITHOUT
from stickslip.servo.measurement import Array
from stickslip.studies.learn.page.signals import (
    Parts,
    measures_friction,
    parts,
    simulated_position,
    sliding,
    steady_friction,
    steady_name,
)


def draw_recording(estimation: Estimation) -> Figure:
    """Draw the signals over time, commands dashed."""
    recording, motion = estimation.recording, estimation.recording.motion
    recorded, velocity = position_of(recording), estimation.figures.velocity_recorded
    position, force = from_start(recorded), measured_force(recording)
    command = recording.position_command
    if command is not None:
        command = command - (recorded[0] - position[0])
    place, push = WORDS[motion]
    place = place.capitalize()
    if recording.position is None:
        place += ", integrated from the velocity"
    elif position is not recorded:
        place += ", from its first value on"
    title = "Measured friction" if measures_friction(estimation) else f"Motor {push}"
    logged = np.concatenate([np.arange(one.begin, one.end) for one in recording.pieces])
    t = recording.t[logged]
    shown = (
        (place, position, command, position_scale(motion, position)),
        (
            "Velocity, low-passed",
            *(velocity, recording.velocity_command, velocity_scale(motion, velocity)),
        ),
        (title, force, None, force_scale(motion, force)),
    )
    figure = style.new_figure(style.PAGE, 115.0)
    panels = figure.subplots(3, 1, sharex=True)
    for axes, letter, (name, signal, wanted, scale) in zip(panels, "abc", shown, strict=True):
        style.zero_lines(axes)
        colour = style.INK if letter == "c" else style.WITH
        _line(axes, t, signal[logged], scale, color=colour, lw=0.8, label="recorded")
        if wanted is not None:
            look: dict[str, Any] = {"color": style.WITHOUT, "lw": 0.8, "ls": style.DASHED}
            _line(axes, t, wanted[logged], scale, label="command", **look)
            _legend_above(axes, 0.28)
        axes.set_ylabel(f"{name.split(',')[0].split()[-1].capitalize()} [{scale.unit}]")
        style.name_panel(axes, letter, name)
    panels[2].set(xlabel="Time [s]", xlim=recording.t[[0, -1]])
    figure.align_ylabels()
    return figure


def _line(axes: Axes, t: Array, signal: Array, scale: Scale, **look: Any) -> None:
    """Draw a signal (n,), with a gap where time is left out."""
    left_out = np.flatnonzero(np.diff(t) > 1.5 * (t[1] - t[0])) + 1
    logs = list(zip(np.split(t, left_out), np.split(scale.factor * signal, left_out), strict=True))

    def shown(columns: int) -> Iterator[Array]:
        for signals in zip(*(thinned(*one, -(-columns // len(logs))) for one in logs), strict=True):
            yield np.concatenate([np.append(one, np.nan) for one in signals])[:-1]

    (line,) = axes.plot(*shown(COLUMNS), **look)
    keep(line, *shown(OPENED))


def _legend_above(axes: Axes, room: float, loc: Any = "upper right") -> Any:
    """Put a legend in one row into room, a share of the range, that is made above the lines."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + room * (high - low))
    return axes.legend(loc=loc, ncols=2)


OPENED = 3000  # Stretches of time of which a signal that opens has the least and the largest value

CLOUD_POINTS, LOOP_POINTS, RESIDUAL_POINTS = 6000, 8000, 5000
"""Points drawn at most of friction over velocity, hysteresis and residual."""


def draw_force(estimation: Estimation) -> Figure:
    """Draw friction or motor force over time and its difference, beside what it depends on.

    That is the position, in loops, where friction was measured, and else the velocity.
    """
    signals, motion = parts(estimation), estimation.recording.motion
    friction = measures_friction(estimation)
    error = f"relative error {percent(estimation.figures.force)}"
    figure = style.new_figure(style.PAGE, 115.0 if friction else 125.0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.15) if friction else (1.35, 1.0))
    over_time, beside = grid[0, int(friction)], grid[0, int(not friction)]
    rows = over_time.subgridspec(2, 1)
    upper = figure.add_subplot(rows[0])
    lower = figure.add_subplot(rows[1], sharex=upper)
    upper.tick_params(labelbottom=False)
    if friction:
        _over_time(upper, lower, signals, estimation, what="Friction", predicted="learned")
        loops = figure.add_subplot(beside)
        _loops(loops, estimation, signals)
        style.name_panel(loops, "a", f"Hysteresis, {error}")
        style.name_panel(upper, "b", "Friction over time")
        style.name_panel(lower, "c", "Recorded less learned")
    else:
        push = WORDS[motion][1].capitalize()
        _over_time(
            upper, lower, signals, estimation, what=push, predicted="predicted by the learned drive"
        )
        _legend_above(upper, 0.2)
        cells = beside.subgridspec(2, 1)
        both, against_speed = (figure.add_subplot(cells[k]) for k in (0, 1))
        _friction(both, against_speed, estimation, signals)
        style.name_panel(upper, "a", f"{push}, {error}")
        style.name_panel(lower, "b", "Recorded less predicted")
        style.name_panel(both, "c", "Friction over velocity")
        style.name_panel(against_speed, "d", "Friction against speed")
        handles, labels = against_speed.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower right", ncols=3, markerscale=4.0)
    figure.align_ylabels((upper, lower))
    return figure


def _over_time(
    upper: Axes, lower: Axes, signals: Parts, estimation: Estimation, what: str, predicted: str
) -> None:
    """Draw recorded and predicted force over time, and their difference below."""
    motion = estimation.recording.motion
    scale, fine = force_scale(motion, signals.measured), force_scale(motion, signals.difference)
    style.zero_lines(upper)
    look: dict[str, Any] = {"color": style.WITHOUT, "lw": 1.6, "alpha": 0.7}
    _line(upper, signals.t, signals.measured, scale, label="recorded", **look)
    _line(upper, signals.t, signals.predicted, scale, color=style.WITH, lw=0.6, label=predicted)
    upper.set_ylabel(f"{what} [{scale.unit}]")
    lower.axhline(0.0, color=style.GREY, lw=style.THIN)
    _line(lower, signals.t, signals.difference, fine, color=style.WITH, lw=0.5)
    lower.set(xlabel="Time [s]", ylabel=f"Difference [{fine.unit}]", xlim=signals.t[[0, -1]])


def _friction(both: Axes, against_speed: Axes, estimation: Estimation, signals: Parts) -> None:
    """Draw friction over velocity, and over the logarithm of speed."""
    motion = estimation.recording.motion
    v, friction = signals.velocity, signals.measured - signals.rest
    steady = sliding(estimation, signals)
    top = float(np.max(np.abs(v)))
    speed = np.geomspace(1e-4 * top, top, 300)
    curve = steady_friction(estimation, np.concatenate([-speed[::-1], speed]))
    highest = float(np.max(np.abs(curve)))
    if steady.any():
        highest = max(highest, float(np.quantile(np.abs(friction[steady]), 0.999)))
    v_scale, scale = velocity_scale(motion, v), force_scale(motion, curve)
    few = spread(len(v), CLOUD_POINTS)
    for rows, colour, label in (
        (few[~steady[few]], style.FAINT, "recorded, soon after a reversal"),
        (few[steady[few]], style.WITHOUT, "recorded, sliding"),
    ):
        x, y = v_scale.factor * v[rows], scale.factor * friction[rows]
        look: dict[str, Any] = {"ms": 2.0, "mew": 0, "color": colour, "rasterized": True}
        both.plot(x, y, ".", **look)
        against_speed.plot(np.abs(x), y * np.sign(x), ".", label=label, **look)
    x, curve = v_scale.factor * speed, scale.factor * curve
    both.plot(-x, curve[:300][::-1], color=style.WITH)
    both.plot(x, curve[300:], color=style.WITH)
    against_speed.plot(x, curve[300:], color=style.WITH, label=f"learned {steady_name(estimation)}")
    shown = estimation.start.curve
    if shown is not None:
        low, high = (scale.factor * end for end in (shown.low, shown.high))
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        look = {"fmt": "none", "ecolor": style.INK, "elinewidth": 1.0, "capsize": 2.0, "zorder": 3}
        label = "sliding, whatever the law: 95 % intervals"
        against_speed.errorbar(v_scale.factor * shown.speed, middle, half, label=label, **look)
    limit = 1.15 * scale.factor * highest
    both.set(ylim=(-limit, limit), xlabel=f"Velocity [{v_scale.unit}]")
    against_speed.set(
        xscale="log", xlim=(x[0], 1.1 * x[-1]), ylim=(0.0, limit),
        xlabel=f"Speed [{v_scale.unit}], logarithmic",
    )  # fmt: skip
    against_speed.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    style.zero_lines(both, vertical=True)
    style.zero_lines(against_speed)
    for axes in (both, against_speed):
        axes.set_ylabel(f"Friction [{scale.unit}]")


def _loops(axes: Axes, estimation: Estimation, signals: Parts) -> None:
    """Draw friction over position."""
    motion = estimation.recording.motion
    x = from_start(signals.position)
    scale, x_scale = force_scale(motion, signals.measured), position_scale(motion, x)
    few = spread(len(x), LOOP_POINTS)
    style.zero_lines(axes)
    for force, colour, label in (
        (signals.measured, style.WITHOUT, "recorded"),
        (signals.predicted, style.WITH, "learned"),
    ):
        axes.plot(
            x_scale.factor * x[few], scale.factor * force[few], color=colour, lw=0.5,
            label=label, rasterized=True,
        )  # fmt: skip
    for line in _legend_above(axes, 0.12, "upper left").get_lines():
        line.set_linewidth(1.5)
    place = WORDS[motion][0].capitalize()
    axes.set(xlabel=f"{place} [{x_scale.unit}]", ylabel=f"Friction [{scale.unit}]")


def draw_residual(estimation: Estimation) -> Figure:
    """Draw the residual over time, position and velocity, and its spectrum."""
    recording, simulated = estimation.recording, simulated_position(estimation)
    motion = recording.motion
    place, what = (word.capitalize() for word in WORDS[motion])
    if simulated is None:
        of = parts(estimation)
        t, x, v, left = of.t, of.position, of.velocity, of.difference
        scale = force_scale(motion, left)
        what = "Friction" if measures_friction(estimation) else what
        title = f"{what}, recorded less predicted"
    else:
        t, x, v = recording.t, position_of(recording), estimation.figures.velocity_recorded
        left = x - simulated
        scale, what = position_scale(motion, left), place
        title = f"{what} in closed loop, recorded less simulated"
    figure = style.new_figure(style.PAGE, 165.0)
    grid = figure.add_gridspec(3, 2)
    over_time = figure.add_subplot(grid[0, :])
    over_time.axhline(0.0, color=style.GREY, lw=style.THIN)
    _line(over_time, t, left, scale, color=style.WITH, lw=0.5)
    over_time.set(xlabel="Time [s]", xlim=t[[0, -1]])
    if simulated is not None and recording.encoder_step > 0.0:
        _encoder_step(over_time, recording.encoder_step, scale)
    x = from_start(x)
    over_x, over_v = (figure.add_subplot(grid[1, k]) for k in (0, 1))
    for axes, name, signal, x_scale in (
        (over_x, place, x, position_scale(motion, x)),
        (over_v, "Velocity", v, velocity_scale(motion, v)),
    ):
        few = spread(len(signal), RESIDUAL_POINTS)
        style.zero_lines(axes)
        axes.plot(
            x_scale.factor * signal[few], scale.factor * left[few], ".", ms=1.5, mew=0,
            color=style.WITH, alpha=0.5, rasterized=True,
        )  # fmt: skip
        axes.set_xlabel(f"{name} [{x_scale.unit}]")
    titles = (title, f"The same over {place.lower()}", "The same over velocity")
    for axes, letter, name in zip((over_time, over_x, over_v), "abc", titles, strict=True):
        style.name_panel(axes, letter, name)
        axes.set_ylabel(f"{what} difference [{scale.unit}]")
    _spectrum(figure.add_subplot(grid[2, :]), scale.factor * left, recording.T_s, scale.unit)
    return figure


SEGMENTS = 8  # Of the residual at least, over which its spectrum is averaged


def _spectrum(axes: Axes, signal: Array, T_s: float, unit: str) -> None:
    """Draw the amplitude spectral density by Welch's method."""
    f, power = welch(signal, 1.0 / T_s, nperseg=max(8, len(signal) // SEGMENTS))
    axes.loglog(f[1:], np.sqrt(power[1:]), color=style.WITH, lw=0.7)
    axes.set(xlabel="Frequency [Hz]", ylabel=f"Density [{unit}/√Hz]", xlim=f[[1, -1]])
    axes.grid(visible=True)
    style.name_panel(axes, "d", "Its amplitude spectral density")


def _encoder_step(axes: Axes, step: float, scale: Scale) -> None:
    """Shade one step of the encoder."""
    half = 0.5 * scale.factor * step
    label = f"one step of the encoder, {number(2 * half, 3)} {scale.unit}"
    axes.axhspan(-half, half, color=style.INK, alpha=0.15, lw=0, zorder=3, label=label)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -1.5 * half), max(high + 0.25 * (high - low), 2.0 * half))
    axes.legend(loc="upper right")


LINE_95 = 3.84  # Deviance at the ends of a 95 % interval
TOP = 10.0
WIDE = 3.0  # Ratio of the ends beyond which an axis is logarithmic
FARTHEST = 1e3  # Ratio to the fitted value beyond which nothing is drawn


def draw_profiles(estimation: Estimation) -> Figure:
    """Draw a panel for each parameter of friction, with its interval and the 95 % line."""
    names = estimation.fit.space.friction
    rows = len(names) // 3 + 1  # one panel more, for the legend
    figure = style.new_figure(style.PAGE, 52.5 * rows)
    panels = figure.subplots(rows, 3, sharey=True, squeeze=False).ravel()
    for axes, letter, name in zip(panels, ascii_lowercase, names, strict=False):
        _panel(axes, estimation, name)
        title = f"{meaning(name, estimation.law)}, {estimation.known[name].identifiability}"
        style.name_panel(axes, letter, fill(title, 40))
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
    profiles = estimation.profiles
    rows = profiles[profiles["parameter"] == name]
    value, deviance = (rows[column].to_numpy(dtype=float) for column in ("value", "deviance"))
    near = (value > fitted / FARTHEST) & (value < fitted * FARTHEST)
    return value[near], deviance[near]


def _resolved(deviance: Array) -> bool:
    """Tell whether a profile is near 1 at one standard error, so that the others did follow.

    One without any rise is none: values beside the learned ones leave no more than these.
    """
    if len(deviance) < 3:
        return False
    fitted = int(np.argmin(deviance))
    beside = [deviance[k] for k in (fitted - 1, fitted + 1) if 0 <= k < len(deviance)]
    return bool(min(beside) < LINE_95 and max(deviance) > 0.0)


def _smooth(value: Array, deviance: Array, fitted: float) -> tuple[Array, Array]:
    """Return a curve through the points: the root of a parabola is a straight line."""
    root = np.sign(value - fitted) * np.sqrt(deviance)
    fine = np.geomspace(value[0], value[-1], 200)
    return fine, PchipInterpolator(np.log(value), root)(np.log(fine)) ** 2


def _ticks(axes: Axes, value: Array) -> None:
    """Put a few ticks on: powers of ten where decades are shown."""
    if value[-1] > WIDE * value[0]:
        axes.set_xscale("log")
        style.log_ticks(axes.xaxis, value[0], value[-1])
        return
    axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    axes.ticklabel_format(axis="x", useOffset=False, style="plain")


def _legend(axes: Axes) -> None:
    handles = [
        Line2D([], [], color=WITH, marker="o", ms=3.0),
        Line2D([], [], color=WITHOUT, lw=0.8),
        Patch(color=SHADE),
        Line2D([], [], color=GREY, lw=0.8, ls=style.DASHED),
    ]
    labels = ["profile likelihood", "learned value", "95 % interval", "95 % level, 3.84"]
    axes.legend(handles, labels, loc="center left")
