"""The section on tracking without and with the compensator: figure and table."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.evaluation.tracking import FEEDFORWARD, FRICTIONLESS, NONE, Tracking, TrackingError
from stickslip.logs import Motion
from stickslip.presentation import style
from stickslip.presentation.markup import paragraph, quiet, table
from stickslip.presentation.page import Illustration, Section
from stickslip.presentation.quantity import number, percentage
from stickslip.presentation.scale import WORDS, Scale, position_scale, thinned, velocity_scale
from stickslip.servo.measurement import Array

FIGURE = "tracking"
ZOOM = 0.04
"""Share of the time that the right column of the figure shows."""
LOOKS = {NONE: style.WITHOUT, FEEDFORWARD: style.WITH}
"""Variants that are drawn, with their colours."""
HEADS = ("Simulated, without", "Simulated, with", "Simulated, no friction")


def tracking_section(
    tracking: Tracking,
    motion: Motion,
    share: float = 1.0,
    *,
    observed: bool = False,
    compared: bool = False,
) -> Section:
    """Return the section.

    Parameters
    ----------
    share : of the compensator's force
    observed : whether an observer was designed, which another section shows
    compared : whether other compensators were tried, which that section shows
    """
    errors = tracking.errors()
    scales = _scales(tracking, motion)
    place = WORDS[motion][0].capitalize()
    names = {
        "velocity_rms": ("Velocity, RMS", scales[0]),
        "velocity_max": ("Velocity, maximum", scales[0]),
        "position_rms": (f"{place}, RMS", scales[1]),
        "position_max": (f"{place}, maximum", scales[1]),
    }
    rows = []
    for key, (title, scale) in names.items():
        values = [_cell(tracking.measured, key, scale)] if tracking.measured else []
        values += [_cell(error, key, scale) for error in errors.values()]
        rows.append((title, scale.unit, *values, percentage(tracking.reduction(key))))
    measured = ("Measured, log",) if tracking.measured else ()
    head = ("Error", "", *measured, *HEADS, "Reduction")
    part = "" if share == 1.0 else f" The compensator gives {percentage(share)} of its force."
    if compared:
        part += " It is that of the law alone; “Whether compensation helps” has what is written."
    elif observed:
        part += " It is the feedforward alone; “Whether compensation helps” has the observer, too."
    return Section(
        "Tracking without and with the compensator",
        paragraph(
            f"Simulated on {tracking.command}, in the loop of {tracking.loop}.{part} ".replace(
                "'", "’"
            )
            + _verdict(tracking, motion)
        ),
        Illustration(
            FIGURE,
            partial(draw_tracking, tracking, motion),
            "Velocity, velocity error and position error over time, without and with compensation",
            f"Simulated drive, without and with the compensator: (a) velocity, (b) its error, (c) "
            f"error of the {place.lower()}; (d) to (f) the same where "
            "compensation changes the velocity most.",
        ),
        table(
            head,
            rows,
            "Tracking error without and with the compensator, and of a drive without friction",
            (0, 1),
        ),
        quiet(_remark(tracking)),
    )


def _verdict(tracking: Tracking, motion: Motion) -> str:
    """Return in a sentence by how much errors change."""
    changes = []
    for key, what in (("velocity_rms", "velocity"), ("position_rms", "position")):
        share = tracking.reduction(key)
        direction = "smaller" if share >= 0.0 else "larger"
        changes.append(f"the RMS error of {what} {percentage(abs(share))} {direction}")
    scale = velocity_scale(motion, np.array([tracking.errors()[NONE].velocity_rms]))
    whole, left = (
        number(scale.factor * tracking.errors()[name].velocity_rms, 3)
        for name in (NONE, FRICTIONLESS)
    )
    return (
        f"The compensator makes {' and '.join(changes)}. Without it that of velocity "
        f"is {whole} {scale.unit}; a drive without friction would have {left} {scale.unit} in "
        "this loop."
    )


def _remark(tracking: Tracking) -> str:
    """Return what the columns of the table are."""
    texts = [
        "Simulated: errors of the true velocity and position of a drive with the learned "
        "parameters, not of the real one.",
        "What is left without friction is due to the loop and its command.",
    ]
    if tracking.measured:
        texts.append("Measured: what the log shows, velocities through a low-pass.")
    return " ".join(texts)


def _cell(error: TrackingError, key: str, scale: Scale) -> str:
    return number(scale.factor * error.items()[key], 3)


def _scales(tracking: Tracking, motion: Motion) -> tuple[Scale, Scale]:
    """Return the units of the errors of velocity and position."""
    without = tracking.errors()[NONE]
    size = np.array([without.velocity_rms]), np.array([without.position_rms])
    return velocity_scale(motion, size[0]), position_scale(motion, size[1])


def draw_tracking(tracking: Tracking, motion: Motion) -> Figure:
    """Draw velocity, its error and that of the position, over the whole time and a part of it."""
    t, (v_scale, x_scale) = tracking.t, _scales(tracking, motion)
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
