"""The three experiments of identification: inertia, friction, and presliding."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from stickslip.identification.stages import FrictionMap
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report import style
from stickslip.report.quantity import with_error

POINTS: Any = {"mec": style.WITHOUT, "ecolor": style.WITHOUT, "capsize": 2.0, "elinewidth": 0.8}
SHOWN = 400
"""Points drawn at most; the low-pass makes neighbours alike."""


def draw_inertia(reproduction: Reproduction) -> Figure:
    """Draw the force without the fitted friction against acceleration, and the line m a."""
    inertia = reproduction.identification.inertia
    thin = slice(None, None, max(1, len(inertia.acceleration) // SHOWN))
    a, force = inertia.acceleration[thin], inertia.force[thin]
    figure = style.new_figure(style.COLUMN, 65.0)
    axes = figure.add_subplot()
    style.zero_lines(axes, vertical=True)
    axes.plot(
        a,
        force,
        "o",
        ms=3.0,
        mfc="none",
        mec=style.WITHOUT,
        mew=0.7,
        label="measured, friction removed",
    )
    ends = np.array([a.min(), a.max()])
    slope = with_error(inertia.m.value, inertia.m.standard_error)
    axes.plot(ends, inertia.m.value * ends, color=style.WITH, label=rf"slope $m$ = {slope} kg")
    axes.set(xlabel="Acceleration [m/s$^2$]", ylabel="Motor force less friction [N]")
    axes.legend(loc="upper left")
    return figure


def draw_friction(reproduction: Reproduction) -> Figure:
    """Draw the map in both directions, and friction against speed, logarithmic."""
    friction = reproduction.identification.friction
    figure = style.new_figure(style.COLUMN, 112.0)
    upper, lower = figure.subplots(2, 1)
    _both_directions(upper, friction)
    _against_speed(lower, friction)
    return figure


def _both_directions(axes: Axes, friction: FrictionMap) -> None:
    top = 1.04 * float(np.abs(friction.velocity).max())
    speed = np.geomspace(1e-6, top, 400)
    style.zero_lines(axes, vertical=True)
    for sign in (1.0, -1.0):
        axes.plot(1e3 * sign * speed, friction.curve(sign * speed), color=style.WITH)
    axes.errorbar(
        1e3 * friction.velocity, friction.force, friction.error,
        fmt="o", ms=3.5, mfc="white", **POINTS,
    )  # fmt: skip
    forward, back = friction.breakaway
    axes.plot([0.0, 0.0], [forward, -back], "D", mfc="none", mec=style.INK, zorder=6)
    axes.set(xlabel="Velocity [mm/s]", ylabel="Motor force [N]")
    style.name_panel(axes, "a", "Both directions")


def _against_speed(axes: Axes, friction: FrictionMap) -> None:
    speeds = np.unique(np.abs(friction.velocity))
    edge = 0.6 * float(speeds[0])
    speed = np.geomspace(edge, 1.25 * float(speeds[-1]), 300)
    axes.plot(1e3 * speed, friction.curve(speed), color=style.WITH, label="fitted curve (4), (5)")
    for sign, marker, size, fill, direction in (
        (1, "o", 3.5, style.WITHOUT, "forward"),
        (-1, "s", 6.0, "none", "back"),
    ):
        side = np.sign(friction.velocity) == sign
        axes.errorbar(
            np.abs(1e3 * friction.velocity[side]), np.abs(friction.force[side]),
            friction.error[side], fmt=marker, ms=size, mfc=fill,
            label=f"{direction}, ±1 standard error", **POINTS,
        )  # fmt: skip
    rate = f"{friction.ramp_rate:.2g} N/s"
    axes.plot(
        [1e3 * edge] * 2, friction.breakaway, "D", mfc="none", mec=style.INK, clip_on=False,
        label=f"break-away, ramp of {rate}",
    )  # fmt: skip
    axes.set_xscale("log")
    axes.set_xlim(1e3 * edge, 1.25e3 * float(speeds[-1]))
    ticks = [tick for tick in (0.1, 0.3, 1, 3, 10, 30, 100) if tick >= 1e3 * edge]
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.set(xlabel="Speed [mm/s], logarithmic", ylabel="Friction [N]")
    style.name_panel(axes, "b", "The Stribeck branch")
    axes.legend(loc="upper right")


def draw_presliding(reproduction: Reproduction) -> Figure:
    """Draw force, encoder position against the fitted one, and what is left of it."""
    presliding = reproduction.identification.presliding
    log = presliding.log
    left = 1e6 * (log.x_enc - presliding.x_fit)
    figure = style.new_figure(style.COLUMN, 112.0)
    force, position, rest = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 1.4, 0.8))
    style.zero_lines(force, position, rest)
    force.plot(log.t, log.F_m, color=style.INK, lw=0.8)
    force.set_ylabel("Motor force [N]")
    style.name_panel(force, "a", "Force steps below break-away")
    position.plot(log.t, 1e6 * log.x_enc, color=style.WITHOUT, lw=2.0, alpha=0.7, label="encoder")
    position.plot(
        log.t, 1e6 * presliding.x_fit, color=style.WITH, lw=style.LINE, label="fitted model"
    )
    position.set_ylabel("Position [µm]")
    position.set_ylim(top=1e6 * (log.x_enc.max() + 0.3 * np.ptp(log.x_enc)))
    position.legend(loc="upper right", ncols=2)
    style.name_panel(position, "b", "Position")
    rest.plot(log.t, left, color=style.WITH, lw=style.THIN)
    rest.set(xlabel="Time [s]", ylabel="Difference [µm]", xlim=(log.t[0], log.t[-1]))
    style.name_panel(rest, "c", "Encoder less model")
    figure.align_ylabels()
    return figure
