"""What each step brings, at a glance: what the page opens with."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from stickslip.evaluation.motions import MOTIONS
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.loop_tuning import FRICTION, STAGES, LoopTuning
from stickslip.presentation import style

LEVEL_LOOKS: Any = {
    0.7: {"marker": "v", "mfc": "white"},
    1.0: {"marker": "o", "mfc": style.WITH},
    1.3: {"marker": "^", "mfc": "white"},
}


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
        labels = [tables.STAGES[stage] for stage in STAGES]
        axes.set_xticks(range(len(labels)), labels, rotation=40, ha="right", rotation_mode="anchor")
        style.name_panel(axes, letter, motion.name.capitalize())
    panels[0].set_ylabel("Error relative to tuned PI [1]")
    style.legend_below(panels[0], 3)
    return figure
