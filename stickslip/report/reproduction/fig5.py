"""Fig. 5: how the cost falls over the generations."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from stickslip import ga
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.style import (
    COLUMN,
    GREY,
    INK,
    LINE,
    SMALL,
    THICK,
    WITH,
    WITHOUT,
    new_figure,
)


def draw(reproduction: Reproduction) -> Figure:
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
