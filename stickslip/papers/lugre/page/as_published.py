"""The learning as published, over seeds, beside least squares from the same coarse starts."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from stickslip import ga
from stickslip.catalog.parameters import LUGRE
from stickslip.evaluation.motions import TRAINING
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.published import OURS, PAPER_COST, SQUARES, START, PublishedStudy
from stickslip.presentation import style
from stickslip.presentation.page import Section
from stickslip.servo.axis import LOOP
from stickslip.tuning.learning import SPREAD

FIG5 = "fig5_as_published"  # Name of the figure of the section


def study_section(study: PublishedStudy) -> Section:
    """Return the section of any study."""
    shown = tables.panel(study)
    panel = {row["method"]: row for row in shown.rows}
    motions = [column.name for column in shown.columns[4:]]
    start, ours, squares = panel[START], panel[OURS], panel[SQUARES]
    found, begun = (
        np.array([[one.parameters[name] for name in LUGRE] for one in study.seeds[method]])
        for method in (OURS, START)
    )
    final = study.costs(OURS)
    return section(
        "The learning as published, and least squares",
        "as_published",
        None,
        {FIG5: partial(draw_band, study)},
        study=study,
        panel=shown,
        ours=ours,
        squares=squares,
        motions=motions,
        fallen=float(np.median(final / study.costs(START))),
        below=int((final <= PAPER_COST).sum()),
        seeds=len(final),
        worse=sum(ours[name] > start[name] for name in motions),
        better=sum(squares[name] <= ours[name] for name in ("cost", *motions)),
        kept=float((np.abs(found / begun - 1.0) < 0.02).mean()),
        samples=round(TRAINING.duration / LOOP.T_s) + 1,
        SPREAD={name: SPREAD[name] for name in LUGRE},
    )


BAND = "#9dbbd6"


def draw_band(study: PublishedStudy) -> Figure:
    """Draw Fig. 5 of a study."""
    table = study.fitness()
    best = table.pivot_table(index="generation", columns="seed", values="best_cost")
    generation = best.index.to_numpy(dtype=float)
    low, first, middle, third, high = np.quantile(best.to_numpy(), (0, 0.25, 0.5, 0.75, 1), axis=1)
    figure = style.new_figure(style.COLUMN, 82.0)
    axes = figure.add_subplot()
    axes.grid(visible=True, axis="y")
    axes.set(yscale="log", xlabel="Generation [1]", xlim=(generation[0], generation[-1]))
    axes.set_ylabel(r"Cost $\sum (v - v_r)^2$ [m$^2$/s$^2$]")
    for bottom, top, colour, label in (
        (low, high, style.PALE, f"{best.shape[1]} seeds, all"),
        (first, third, BAND, "middle half of them"),
    ):
        axes.fill_between(generation, bottom, top, step="post", color=colour, lw=0, label=label)
    axes.step(generation, middle, where="post", color=style.WITH, lw=style.THICK, label="median")
    costs, runs = study.costs(SQUARES), np.median([one.runs for one in study.seeds[SQUARES]])
    middle_cost, at = float(np.median(costs)), float(runs) / ga.PAPER.population
    axes.errorbar(
        [at], [middle_cost], [[middle_cost - costs.min()], [costs.max() - middle_cost]],
        fmt="D", ms=4.0, mfc="white", mec=style.INK, ecolor=style.INK, capsize=2.0,
        label=f"least squares, {runs:.0f} runs",
    )  # fmt: skip
    axes.axhline(
        PAPER_COST, color=style.INK, lw=0.8, ls=style.DASHED, label="real stage (paper), end"
    )
    axes.axhline(
        study.cost_without, color=style.WITHOUT, lw=0.8, ls=(0, (1, 1.5)),
        label="no compensation",
    )  # fmt: skip
    style.legend_below(axes, 2)
    return figure
