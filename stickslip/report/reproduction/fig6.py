"""Fig. 6: the trapezoid (a), the motion-start (b) and the motion-reverse region (c)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.evaluation.validation import Run, Validation
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.style import (
    FAINT,
    GREY,
    INK,
    LINE,
    PAGE,
    SHADE,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)
from stickslip.servo.datasheet import REGION
from stickslip.servo.measurement import Array

SHOWN = (-0.02, 0.15)
"""What is drawn around an instant [s]."""


def draw(reproduction: Reproduction) -> Figure:
    """Draw command, velocities and their errors."""
    return draw_tracking(reproduction.validation)


def draw_tracking(validation: Validation) -> Figure:
    """Draw those of a validation."""
    figure = new_figure(PAGE, 140.0)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 0.9, 1.1))
    _whole(figure.add_subplot(grid[0, :]), validation)
    below: Axes | None = None
    for column, (letter, region) in enumerate((("b", "start"), ("c", "reverse"))):
        upper = figure.add_subplot(grid[1, column])
        below = figure.add_subplot(grid[2, column], sharex=upper, sharey=below)
        upper.tick_params(labelbottom=False)
        _velocity(upper, validation, region)
        _error(below, validation, region)
        name_panel(upper, letter, f"Motion-{region} region, simulated drive")
        below.set_xlabel(f"Time after motion {region}s [ms]")
        if column == 0:
            upper.set_ylabel("Velocity [mm/s]")
            below.set_ylabel(r"Error $v_{cmd} - v$ [mm/s]")
    handles, labels = below.get_legend_handles_labels() if below else ([], [])
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _whole(axes: Axes, validation: Validation) -> None:
    run = validation.compensated
    axes.axhline(0.0, color=FAINT, lw=THIN)
    for region, instant in validation.instants.items():
        axes.axvspan(instant + SHOWN[0], instant + SHOWN[1], color=SHADE, lw=0)
        axes.annotate(
            {"start": "(b)", "reverse": "(c)"}[region],
            (instant + sum(SHOWN) / 2, 0.96), xycoords=("data", "axes fraction"),
            ha="center", va="top",
        )  # fmt: skip
    axes.plot(
        run.t, 1e3 * run.v["measured"], color=WITH, lw=2.0, alpha=0.55,
        label=r"measured $v$, with compensation",
    )  # fmt: skip
    axes.plot(run.t, 1e3 * run.v_cmd, color=INK, lw=0.8, ls=(0, (4, 2)), label=r"command $v_{cmd}$")
    axes.set_xlim(run.t[0], run.t[-1])
    axes.set(xlabel="Time [s]", ylabel="Velocity [mm/s]")
    name_panel(axes, "a", "Trapezoid, simulated drive")
    axes.legend(loc="lower left")


def _velocity(axes: Axes, validation: Validation, region: str) -> None:
    t, part = _around(validation.without, validation.instants[region])
    _shade(axes)
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.plot(t, 1e3 * validation.without.v_cmd[part], color=INK, lw=0.8, ls=(0, (4, 2)))
    for run, colour, _ in _runs(validation):
        axes.plot(t, 1e3 * run.v["measured"][part], color=colour, lw=LINE)
    axes.set_xlim(t[0], t[-1])


def _error(axes: Axes, validation: Validation, region: str) -> None:
    t, part = _around(validation.without, validation.instants[region])
    _shade(axes, "judged")
    axes.axhline(0.0, color=GREY, lw=THIN)
    for run, colour, said in _runs(validation):
        true, measured = (1e3 * (run.v_cmd - run.v[v])[part] for v in ("true", "measured"))
        axes.plot(t, measured, color=colour, lw=1.3, label=f"{said} compensation, measured")
        axes.plot(t, true, color=colour, lw=THIN, label=f"{said}, true")


def _runs(validation: Validation) -> tuple[tuple[Run, str, str], ...]:
    return (
        (validation.without, WITHOUT, "without"),
        (validation.compensated, WITH, "with"),
    )


def _shade(axes: Axes, label: str | None = None) -> None:
    axes.axvspan(1e3 * REGION[0], 1e3 * REGION[1], color=SHADE, lw=0, label=label)


def _around(run: Run, instant: float) -> tuple[Array, slice]:
    """Return times after an instant [ms], and which samples they are."""
    begin, end = np.searchsorted(run.t, [instant + edge - 1e-9 for edge in SHOWN])
    part = slice(int(begin), int(end) + 1)
    return 1e3 * (run.t[part] - instant), part
