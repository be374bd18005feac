"""Identification, stage 2: friction over velocity, and break-away."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from stickslip.identification.stages import FrictionMap
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.style import (
    COLUMN,
    FAINT,
    INK,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)


def draw(reproduction: Reproduction) -> Figure:
    """Draw the map in both directions, and its magnitude over the logarithm of speed."""
    friction = reproduction.identification.friction
    figure = new_figure(COLUMN, 112.0)
    upper, lower = figure.subplots(2, 1)
    _directions(upper, friction)
    _magnitude(lower, friction)
    return figure


def _directions(axes: Axes, friction: FrictionMap) -> None:
    top = 1.04 * float(np.abs(friction.velocity).max())
    speed = np.geomspace(1e-6, top, 400)
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.axvline(0.0, color=FAINT, lw=THIN)
    for sign in (1.0, -1.0):
        axes.plot(1e3 * sign * speed, friction.curve(sign * speed), color=WITH)
    axes.errorbar(
        1e3 * friction.velocity, friction.force, friction.error,
        fmt="o", ms=3.5, mfc="white", mec=WITHOUT, ecolor=WITHOUT, capsize=2.0, elinewidth=0.8,
    )  # fmt: skip
    forward, back = friction.breakaway
    axes.plot([0.0, 0.0], [forward, -back], "D", mfc="none", mec=INK, zorder=6)
    axes.set(xlabel="Velocity [mm/s]", ylabel="Motor force [N]")
    name_panel(axes, "a", "Both directions")


def _magnitude(axes: Axes, friction: FrictionMap) -> None:
    speeds = np.unique(np.abs(friction.velocity))
    edge = 0.6 * float(speeds[0])
    speed = np.geomspace(edge, 1.25 * float(speeds[-1]), 300)
    axes.plot(1e3 * speed, friction.curve(speed), color=WITH, label="fitted curve (4), (5)")
    for sign, marker, fill, said in ((1, "o", WITHOUT, "forward"), (-1, "s", "white", "back")):
        side = np.sign(friction.velocity) == sign
        speeds_of, force = np.abs(friction.velocity[side]), np.abs(friction.force[side])
        axes.errorbar(
            1e3 * speeds_of, force, friction.error[side],
            fmt=marker, ms=3.5 if sign > 0 else 6.0, mfc=fill if sign > 0 else "none", mec=WITHOUT,
            ecolor=WITHOUT, capsize=2.0, elinewidth=0.8, label=f"{said}, ±1 standard error",
        )  # fmt: skip
    rate = f"{friction.ramp_rate:.2g} N/s"
    axes.plot(
        [1e3 * edge] * 2, friction.breakaway, "D", mfc="none", mec=INK, clip_on=False,
        label=f"break-away, ramp of {rate}",
    )  # fmt: skip
    axes.set_xscale("log")
    axes.set_xlim(1e3 * edge, 1.25e3 * float(speeds[-1]))
    ticks = [tick for tick in (0.1, 0.3, 1, 3, 10, 30, 100) if tick >= 1e3 * edge]
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.set(xlabel="Speed [mm/s], logarithmic", ylabel="Force magnitude [N]")
    name_panel(axes, "b", "The Stribeck branch")
    axes.legend(loc="upper right")
