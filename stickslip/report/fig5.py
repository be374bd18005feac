"""Fig. 5: how the cost falls over the generations."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

import ga
from stickslip.report.style import COLUMN, GREY, INK, THICK, WITH, WITHOUT, new_figure
from stickslip.reproduction import Reproduction


def draw(reproduction: Reproduction) -> Figure:
    """Draw best and mean cost, with the identified and the final parameters marked."""
    final = reproduction.learned.cost, _final(reproduction)
    return draw_course(reproduction.algorithm, r"$\sum (v - v_r)^2$ [m$^2$/s$^2$]", final)


def draw_course(
    algorithm: ga.Optimiser, cost: str, final: tuple[float, str] | None = None
) -> Figure:
    """Draw best and mean cost of an algorithm.

    Parameters
    ----------
    cost : what it is, with its unit
    final : a cost after the last generation, and what it is of
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
    axes.plot(generation[0], identified, "o", mfc="white", label="identified parameters", **marks)
    if final is not None:
        axes.plot(generation[-1], final[0], "D", mfc=GREY, label=final[1], **marks)
    axes.set_xlim(generation[0], max(generation[-1], generation[0] + 1.0))
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
    second.set_xlabel("Evaluations [1]")
    return figure


def _final(reproduction: Reproduction) -> str:
    return "after refinement" if reproduction.learned.accepted else "winner, typical run"
