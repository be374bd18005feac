"""Figs. 5 and 6, the slow motions, and the errors step by step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from stickslip import ga
from stickslip.evaluation.motion_study import LEARNED, UNCOMPENSATED
from stickslip.evaluation.motions import SLOW_MOTIONS, Motion
from stickslip.evaluation.validation import PAPER_TABLE4, Run, Validation
from stickslip.pipeline.reproduction import Reproduction
from stickslip.pipeline.steps import STEPS
from stickslip.report.style import (
    COLUMN,
    FAINT,
    GREY,
    INK,
    LINE,
    PAGE,
    SHADE,
    SMALL,
    THICK,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)
from stickslip.servo.datasheet import REGION
from stickslip.servo.measurement import Array


def draw_fitness(reproduction: Reproduction) -> Figure:
    """Draw best and mean cost, and those without compensation, identified and in the end."""
    learned = reproduction.learned
    final = learned.cost, learned.result
    without = reproduction.cost_without
    cost = r"$\sum (v - v_r)^2$ [m$^2$/s$^2$]"
    figure = draw_course(reproduction.algorithm, cost, final, without)
    if learned.skipped:
        figure.axes[0].annotate(
            "nothing was searched:\nno parameters would halve the cost",
            (0.5, 0.5), xycoords="axes fraction", ha="center", va="center",
        )  # fmt: skip
    return figure


def draw_course(
    algorithm: ga.Optimiser,
    cost: str,
    final: tuple[float, str] | None = None,
    without: float | None = None,
) -> Figure:
    """Draw best and mean cost of an algorithm.

    Parameters
    ----------
    cost : what it is, with its unit
    final : a cost after the last generation, and what it is of
    without : cost without compensation
    """
    line = algorithm.convergence()
    generation = line["generation"].to_numpy(dtype=float)
    evaluations = line["evaluations"].to_numpy(dtype=float)
    best = line["best_cost"].to_numpy(dtype=float)
    mean = line["mean_cost"].to_numpy(dtype=float)
    identified = float(algorithm.history["cost"].iloc[0])

    figure = new_figure(COLUMN, 78.0)
    axes = figure.add_subplot()
    axes.set_yscale("log")
    axes.grid(visible=True, axis="y")
    axes.plot(
        generation, np.where(np.isfinite(mean), mean, np.nan),
        color=WITHOUT, ls=(0, (4, 1.5)), label="mean of the generation",
    )  # fmt: skip
    axes.step(generation, best, where="post", color=WITH, lw=THICK, label="best so far")
    marks: Any = {"mec": INK, "ls": "none", "clip_on": False, "zorder": 5}
    axes.plot(generation[0], identified, "o", mfc="white", label="start", **marks)
    if final is not None:
        axes.plot(generation[-1], final[0], "D", mfc=GREY, label=final[1], **marks)
    if without is not None:
        axes.axhline(without, color=GREY, lw=LINE)
        axes.annotate(
            f"without compensation: {without:.2g}",
            (1.0, without),
            (-2.0, -3.0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=SMALL,
        )
    axes.set_xlim(generation[0], max(generation[-1], generation[0] + 1.0))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("Generation [1]")
    axes.set_ylabel(f"Cost {cost}")
    figure.legend(loc="outside lower center", ncols=2)

    # After the first generation each one adds as many evaluations.
    span = max(generation[-1] - generation[0], 1.0)
    slope = max((evaluations[-1] - evaluations[0]) / span, 1.0)
    second = axes.secondary_xaxis(
        "top",
        functions=(
            lambda g: evaluations[0] + slope * (g - generation[0]),
            lambda e: generation[0] + (e - evaluations[0]) / slope,
        ),
    )
    second.xaxis.set_major_locator(MaxNLocator(integer=True))
    second.set_xlabel("Evaluations [1]")
    return figure


SHOWN = (-0.02, 0.15)
"""What is drawn around an instant [s]."""


def draw_tracking(validation: Validation) -> Figure:
    """Draw command, velocities and their errors."""
    figure = new_figure(PAGE, 140.0)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 0.9, 1.1))
    _whole(figure.add_subplot(grid[0, :]), validation)
    below: Axes | None = None
    for column, (letter, region) in enumerate((("b", "start"), ("c", "reverse"))):
        upper = figure.add_subplot(grid[1, column])
        below = figure.add_subplot(grid[2, column], sharex=upper, sharey=below)
        upper.tick_params(labelbottom=False)
        _velocities(upper, validation, region)
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


def _velocities(axes: Axes, validation: Validation, region: str) -> None:
    t, part = _around(validation.without, validation.instants[region])
    _shade(axes)
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.plot(t, 1e3 * validation.without.v_cmd[part], color=INK, lw=0.8, ls=(0, (4, 2)))
    for run, colour, _ in _runs(validation):
        axes.plot(t, 1e3 * run.v["measured"][part], color=colour, lw=LINE)
    axes.set_xlim(t[0], t[-1])


def _error(axes: Axes, validation: Validation, region: str) -> None:
    t, part = _around(validation.without, validation.instants[region])
    _shade(axes, "evaluated")
    axes.axhline(0.0, color=GREY, lw=THIN)
    for run, colour, label in _runs(validation):
        true, measured = (1e3 * (run.v_cmd - run.v[v])[part] for v in ("true", "measured"))
        axes.plot(t, measured, color=colour, lw=1.3, label=f"{label} compensation, measured")
        axes.plot(t, true, color=colour, lw=THIN, label=f"{label}, true")


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


REVERSALS, CREEP, MOVES = SLOW_MOTIONS
BEFORE = 0.05
"""What is drawn before the first of the spans [s]."""


def draw_motions(reproduction: Reproduction) -> Figure:
    """Draw the command, the motion without compensation and with what was learned."""
    assert reproduction.motions is not None  # noqa: S101 - it is drawn once they were run
    evaluation = reproduction.motions.evaluation
    figure = new_figure(PAGE, 66.0)
    panels = figure.subplots(1, 3)
    shown = (
        ("a", REVERSALS, "0.5 mm/s", "Slow reversals"),
        ("b", CREEP, "0.3 mm/s", "Creep"),
        ("c", MOVES, "20 um", "Micrometre moves"),
    )
    for axes, (letter, motion, region, title) in zip(panels, shown, strict=True):
        runs = evaluation.runs[motion.name]
        _motion(axes, motion, region, runs[UNCOMPENSATED], runs[LEARNED])
        name_panel(axes, letter, f"{title}, {region.replace('um', 'µm')}")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _motion(axes: Axes, motion: Motion, region: str, without: Run, compensated: Run) -> None:
    spans = motion.regions[region]
    begin, end = spans[0][0] - BEFORE, spans[-1][1]
    part = (without.t >= begin) & (without.t <= end)
    t = without.t[part] - spans[0][0]
    axes.axhline(0.0, color=FAINT, lw=THIN)
    lines = (
        (without, WITHOUT, "without compensation"),
        (compensated, WITH, "with the learned compensator"),
    )
    if motion is MOVES:
        quantity, scale, command = "position [µm]", 1e6, without.x_cmd
    else:
        quantity, scale, command = "velocity [mm/s]", 1e3, without.v_cmd
    for run, colour, label in lines:
        values = run.x_enc if motion is MOVES else run.v["measured"]
        axes.plot(t, scale * values[part], color=colour, lw=0.7, label=label)
    axes.plot(t, scale * command[part], color=INK, lw=0.8, ls=(0, (4, 2)), label="command")
    axes.set_xlim(t[0], t[-1])
    axes.set_xlabel("Time [s]")
    axes.set_ylabel(f"Measured {quantity}")


LOOKS = {
    ("start", "E_max"): ("o", WITHOUT, "white", "start, $E_{max}$"),
    ("start", "E_rms"): ("o", WITHOUT, WITHOUT, "start, $E_{rms}$"),
    ("reverse", "E_max"): ("s", WITH, "white", "reverse, $E_{max}$"),
    ("reverse", "E_rms"): ("s", WITH, WITH, "reverse, $E_{rms}$"),
}
"""Marker, edge, face and name of each error."""


def draw_steps(reproduction: Reproduction) -> Figure:
    """Draw the errors on the drive's true velocity, and on that of the drive with all effects."""
    drives = {"Simulated drive": reproduction.table4()}
    if reproduction.extras and reproduction.extras.table4 is not None:
        drives["Simulated drive, all extras on"] = reproduction.extras.table4
    figure = new_figure(PAGE, 78.0)
    panels = figure.subplots(1, len(drives), sharey=True, squeeze=False)[0]
    for axes, letter, (name, table) in zip(panels, "abc", drives.items(), strict=False):
        _step_errors(axes, table)
        name_panel(axes, letter, name)
    panels[0].set_ylabel("Error on the true velocity [mm/s]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _step_errors(axes: Axes, table: pd.DataFrame) -> None:
    true = table[table["velocity"] == "true"].rename(columns={"with": LEARNED})
    names = [name for name in STEPS if name in true]
    axes.set_yscale("log")
    axes.grid(visible=True, axis="y")
    for shift, (key, (marker, edge, face, label)) in enumerate(LOOKS.items()):
        row = true[(true["region"] == key[0]) & (true["metric"] == key[1])].iloc[0]
        x = [place + 0.14 * (shift - 1.5) for place in range(len(names))]
        axes.plot(
            x, [row[name] for name in names], marker, ls="none", ms=4.5, mec=edge, mfc=face,
            mew=0.9, label=label,
        )  # fmt: skip
    for place, colour, which in ((0, GREY, "without"), (1, INK, "with")):
        values = [both[place] for both in PAPER_TABLE4.values()]
        label = f"real stage (paper), {which}"
        axes.axhspan(min(values), max(values), color=colour, alpha=0.13, lw=0, label=label)
    labels = [STEPS[name] for name in names]
    axes.set_xticks(range(len(names)), labels, rotation=35, ha="right", rotation_mode="anchor")
