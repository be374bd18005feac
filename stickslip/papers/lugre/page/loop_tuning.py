"""What each step brings, at a glance: what the page opens with."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.validation import PHASES
from stickslip.papers.lugre.loop_tuning import FRICTION, STAGES, LoopTuning, spread
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation import style
from stickslip.presentation.markup import Html, paragraph, table
from stickslip.presentation.page import Illustration

NAMES = {
    "none": "None",
    "tuned_pi": "Tuned PI alone",
    "identified": "+ identified friction",
    "least_squares": "+ least squares",
    "learned": "Loop learned",
}
"""The stages as the page names them."""
LEVEL_LOOKS: Any = {
    0.7: {"marker": "v", "mfc": "white"},
    1.0: {"marker": "o", "mfc": style.WITH},
    1.3: {"marker": "^", "mfc": "white"},
}


def steps_at_a_glance(reproduction: Reproduction) -> tuple[Html | Illustration, ...]:
    """Return what the page opens with: errors of each step, relative to a tuned PI controller."""
    loops = reproduction.loops
    return (
        paragraph(f"{loops.sentence[0].upper()}{loops.sentence[1:]}."),
        Illustration(
            "loop_tuning",
            partial(draw_stages, loops),
            "Errors of four motions, step by step, relative to a tuned PI controller",
            "What each step brings, in four motions: the error of the true velocity relative to "
            "that of a PI controller whose gains are tuned without any model of friction. The "
            "simulated drive has its own friction (circles), and 0.7 and 1.3 times as much, to "
            "which nothing is learned again. Bars: range over "
            f"{len(loops.learned)} seeds of the search. Each point is a median over "
            f"{len(PHASES)} places within a step of the encoder from which the motion begins.",
        ),
        _stages(loops),
    )


def _stages(loops: LoopTuning) -> Html:
    summary, rows = loops.summary(), []
    for stage, name in NAMES.items():
        own = summary.loc[stage]
        cells = [spread(*own[motion.name]) for motion in MOTIONS]
        rows.append((name, *cells, f"{own['Ms'].iloc[0]:.2f}", _cost(loops, stage)))
    head = ("", *(motion.name.capitalize() for motion in MOTIONS), "Ms", "Runs of the drive")
    caption = (
        "Errors relative to the tuned PI controller alone: median [range] over friction "
        f"× {', × '.join(f'{level:g}' for level in FRICTION)} and seeds"
    )
    return table(head, rows, caption)


def _cost(loops: LoopTuning, stage: str) -> str:
    if stage == "learned":
        return f"{max(one.runs for one in loops.learned)} more"
    if stage == "least_squares":
        own = loops.table[loops.table["stage"] == stage]
        return f"{own['evaluations'].max()} more"
    return {"none": "–", "tuned_pi": "–", "identified": "three experiments"}[stage]


def draw_stages(loops: LoopTuning) -> Figure:
    """Draw the errors of each step relative to the tuned PI controller, a panel for each motion."""
    figure = style.new_figure(style.PAGE, 74.0)
    panels = figure.subplots(1, len(MOTIONS), sharey=True)
    for axes, letter, motion in zip(panels, "abcd", MOTIONS, strict=True):
        rows = loops.ratios[loops.ratios["motion"] == motion.name]
        for shift, level in zip((-0.22, 0.0, 0.22), FRICTION, strict=True):
            own = rows[rows["friction"] == level].groupby("stage", sort=False)["ratio"]
            middle, low, high = own.median(), own.min(), own.max()
            axes.errorbar(
                np.arange(len(middle)) + shift, middle, (middle - low, high - middle),
                ls="none", ms=4.0, mec=style.WITH, ecolor=style.WITH, elinewidth=0.8,
                label=f"friction × {level:g}", **LEVEL_LOOKS[level],
            )  # fmt: skip
        axes.axhline(1.0, color=style.GREY, lw=style.THIN)
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(FixedLocator([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        axes.grid(visible=True, axis="y")
        labels = [NAMES[stage] for stage in STAGES]
        axes.set_xticks(range(len(labels)), labels, rotation=40, ha="right", rotation_mode="anchor")
        style.name_panel(axes, letter, motion.name.capitalize())
    panels[0].set_ylabel("Error relative to tuned PI [1]")
    style.legend_below(panels[0], 3)
    return figure
