"""Identification, stage 3: small force steps and the bristles' answer."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.style import (
    COLUMN,
    FAINT,
    INK,
    LINE,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)


def draw(reproduction: Reproduction) -> Figure:
    """Draw force, encoder position against the fitted one, and what is left of it."""
    presliding = reproduction.identification.presliding
    log = presliding.log
    left = 1e6 * (log.x_enc - presliding.x_fit)
    figure = new_figure(COLUMN, 112.0)
    force, position, rest = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 1.4, 0.8))
    for axes in (force, position, rest):
        axes.axhline(0.0, color=FAINT, lw=THIN)
    force.plot(log.t, log.F_m, color=INK, lw=0.8)
    force.set_ylabel("Motor force [N]")
    name_panel(force, "a", "Force steps below break-away")
    position.plot(log.t, 1e6 * log.x_enc, color=WITHOUT, lw=2.0, alpha=0.7, label="encoder")
    position.plot(log.t, 1e6 * presliding.x_fit, color=WITH, lw=LINE, label="fitted model")
    position.set_ylabel("Position [µm]")
    position.set_ylim(top=1e6 * (log.x_enc.max() + 0.3 * np.ptp(log.x_enc)))
    position.legend(loc="upper right", ncols=2)
    name_panel(position, "b", "Position")
    rest.plot(log.t, left, color=WITH, lw=THIN)
    rest.set(xlabel="Time [s]", ylabel="Difference [µm]", xlim=(log.t[0], log.t[-1]))
    name_panel(rest, "c", "Encoder less model")
    figure.align_ylabels()
    return figure
