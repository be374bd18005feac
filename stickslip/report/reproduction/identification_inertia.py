"""Identification, stage 1: force over acceleration; the slope is the inertia."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.quantity import with_error
from stickslip.report.style import (
    COLUMN,
    FAINT,
    THIN,
    WITH,
    WITHOUT,
    new_figure,
)

SHOWN = 400
"""Points drawn at most; the low-pass makes neighbours alike."""


def draw(reproduction: Reproduction) -> Figure:
    """Draw the force without the fitted friction against acceleration, and the line m a."""
    inertia = reproduction.identification.inertia
    thin = slice(None, None, max(1, len(inertia.acceleration) // SHOWN))
    a, force = inertia.acceleration[thin], inertia.force[thin]
    figure = new_figure(COLUMN, 65.0)
    axes = figure.add_subplot()
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.axvline(0.0, color=FAINT, lw=THIN)
    axes.plot(
        a, force, "o", ms=3.0, mfc="none", mec=WITHOUT, mew=0.7, label="measured, friction removed"
    )
    ends = np.array([a.min(), a.max()])
    said = with_error(inertia.m.value, inertia.m.standard_error)
    axes.plot(ends, inertia.m.value * ends, color=WITH, label=rf"slope $m$ = {said} kg")
    axes.set(xlabel="Acceleration [m/s$^2$]", ylabel="Motor force less friction [N]")
    axes.legend(loc="upper left")
    return figure
