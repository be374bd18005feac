"""The figure of a tuned loop: errors in each motion, in the present loop and in the tuned one."""

from __future__ import annotations

import math
import re

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from stickslip.presentation import style
from stickslip.studies.tune.run import PRESENT, TUNED, TunedDrive
from stickslip.trial.benefit import MotionErrors

FIGURE = "errors"
WIDTH = 0.5  # of the levels of friction beside each other, over the distance of motions
DECADES = 30.0  # range of the errors from where on only powers of ten are labelled


def draw_errors(found: TunedDrive) -> Figure:
    """Draw a panel for velocity and, in a cascade, position."""
    motions = found.benefit.motions
    figures = list(dict.fromkeys(one.rows[0].figure for one in motions))
    figure = style.new_figure(style.COLUMN, 20.0 + 48.0 * len(figures))
    panels = figure.subplots(len(figures), 1, sharex=True, squeeze=False)[:, 0]
    for axes, letter, name in zip(panels, "ab", figures, strict=False):
        own = [one for one in motions if one.rows[0].figure == name]
        factor, unit = found.benefit.shown(own[0].rows[0])
        _draw(axes, own, factor)
        axes.set_ylabel(f"RMS error [{unit.replace('u', 'µ')}]")
        style.name_panel(axes, letter, name.capitalize())
    style.legend_below(panels[0])
    figure.align_ylabels(panels)
    return figure


def _draw(axes: Axes, motions: list[MotionErrors], factor: float) -> None:
    names = list(dict.fromkeys(one.rows[0].command for one in motions))
    levels = sorted({one.level for one in motions})
    shifts = dict(zip(levels, np.linspace(-WIDTH / 2, WIDTH / 2, len(levels)), strict=True))
    x = [names.index(one.rows[0].command) + shifts[one.level] for one in motions]
    # Over the drives on which the present loop does not run away.
    pairs = [
        [(row.without, row.compensated) for row in one.rows if math.isfinite(row.without)]
        for one in motions
    ]
    errors = factor * np.array([np.sqrt(np.mean(np.square(pair), axis=0)) for pair in pairs])
    axes.vlines(x, *errors.T, color=style.GREY, lw=style.THIN)
    axes.plot(x, errors[:, 0], "o", color=style.WITHOUT, mfc="white", label=PRESENT)
    axes.plot(x, errors[:, 1], "o", color=style.WITH, label=TUNED)
    axes.set_yscale("log")
    wide = errors.max() > DECADES * errors.min()
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(visible=True, axis="y")
    axes.set_xticks(range(len(names)), [re.sub(r" |(?<=-)", "\n", name) for name in names])
