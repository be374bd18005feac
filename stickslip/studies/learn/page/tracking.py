"""The section on tracking without and with the compensator: figure and table."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.evaluation.tracking import FEEDFORWARD, FRICTIONLESS, NONE, Tracking
from stickslip.logs import Motion
from stickslip.presentation import style
from stickslip.presentation.page import Section
from stickslip.presentation.scale import WORDS, thinned, velocity_scale
from stickslip.servo.measurement import Array
from stickslip.studies.learn import tables

FIGURE = "tracking"
ZOOM = 0.04  # Share of the time that the right column of the figure shows
LOOKS = {NONE: style.WITHOUT, FEEDFORWARD: style.WITH}
"""Variants that are drawn, with their colours."""


def tracking_section(tracking: Tracking, motion: Motion, compensator: str = "") -> Section:
    """Return the section; the compensator is named as it is written."""
    errors = tracking.errors()
    return Section(
        "Tracking without and with the compensator",
        "studies/learn/page/tracking.j2",
        {FIGURE: partial(draw_tracking, tracking, motion)},
        tracking=tracking,
        errors=errors,
        found=tables.tracking(tracking, motion),
        scale=velocity_scale(motion, errors[NONE].velocity_rms),
        place=WORDS[motion][0],
        compensator=compensator,
        NONE=NONE,
        FRICTIONLESS=FRICTIONLESS,
    )


def draw_tracking(tracking: Tracking, motion: Motion) -> Figure:
    """Draw velocity, its error and that of the position, over the whole time and a part of it."""
    t, (v_scale, x_scale) = tracking.t, tables.tracking_scales(tracking.errors()[NONE], motion)
    command_scale = velocity_scale(motion, tracking.v_cmd)
    place = WORDS[motion][0].capitalize()
    figure = style.new_figure(style.PAGE, 130.0)
    panels = figure.subplots(3, 2, sharex="col", width_ratios=(1.4, 1.0))
    for column, part in enumerate((tracking.used, window(tracking))):
        velocity, v_error, x_error = panels[:, column]
        style.zero_lines(velocity, v_error, x_error)
        for name, colour in LOOKS.items():
            look = {"color": colour, "lw": 0.8, "label": name}
            signals = (
                (velocity, tracking.velocity[name], command_scale),
                (v_error, tracking.velocity_error(name), v_scale),
                (x_error, tracking.position_error[name], x_scale),
            )
            for axes, signal, scale in signals:
                axes.plot(*thinned(t[part], scale.factor * signal[part]), **look)
        look = {"color": style.INK, "lw": 0.7, "ls": style.DASHED, "label": "command"}
        velocity.plot(*thinned(t[part], command_scale.factor * tracking.v_cmd[part]), **look)
        x_error.set(xlabel="Time [s]", xlim=t[part][[0, -1]])
    titles = ("Velocity", "Velocity error", f"{place} error")
    units = (command_scale, v_scale, x_scale)
    for row, (title, scale) in enumerate(zip(titles, units, strict=True)):
        _name(panels[row, 0], "abc"[row], title, f"{title.split()[-1].capitalize()} [{scale.unit}]")
        _name(panels[row, 1], "def"[row], f"{title}, detail", "")
    style.legend_below(panels[0, 0])
    figure.align_ylabels(panels[:, 0])
    return figure


def _name(axes: Axes, letter: str, title: str, label: str) -> None:
    style.name_panel(axes, letter, f"{title}, simulated")
    axes.set_ylabel(label)


def window(tracking: Tracking) -> slice:
    """Return the samples in which compensation changes the velocity most, in energy."""
    change = (tracking.velocity[FEEDFORWARD] - tracking.velocity[NONE])[tracking.used] ** 2
    begin = tracking.used.start or 0
    n = max(2, min(len(change), round(ZOOM * len(change))))
    energy: Array = np.cumsum(np.append(0.0, change))
    energy = energy[n:] - energy[:-n]
    first = begin + int(np.argmax(energy))
    return slice(first, first + n)
