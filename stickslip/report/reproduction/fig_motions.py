"""The slow motions: a reversal (a), creep (b) and moves of micrometres (c)."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.evaluation.motion_study import LEARNED, UNCOMPENSATED
from stickslip.evaluation.motions import SLOW_MOTIONS, Motion
from stickslip.evaluation.validation import Run
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.style import (
    FAINT,
    INK,
    PAGE,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)

REVERSALS, CREEP, MOVES = SLOW_MOTIONS
BEFORE = 0.05
"""What is drawn before the first of the spans [s]."""


def draw(reproduction: Reproduction) -> Figure:
    """Draw the command, the motion without compensation and with what was learned."""
    assert reproduction.motions is not None  # noqa: S101 - it is drawn once they were run
    evaluation = reproduction.motions.evaluation
    figure = new_figure(PAGE, 66.0)
    panels = figure.subplots(1, 3)
    shown = (
        ("a", REVERSALS, "0.5 mm/s", "Slow reversals"),
        ("b", CREEP, "0.3 mm/s", "Creep"),
        ("c", MOVES, "20 um", "Micrometre moves"),
    )
    for axes, (letter, motion, region, title) in zip(panels, shown, strict=True):
        runs = evaluation.runs[motion.name]
        _panel(axes, motion, region, runs[UNCOMPENSATED], runs[LEARNED])
        name_panel(axes, letter, f"{title}, {region.replace('um', 'µm')}")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _panel(axes: Axes, motion: Motion, region: str, without: Run, compensated: Run) -> None:
    spans = motion.regions[region]
    begin, end = spans[0][0] - BEFORE, spans[-1][1]
    part = (without.t >= begin) & (without.t <= end)
    t = without.t[part] - spans[0][0]
    axes.axhline(0.0, color=FAINT, lw=THIN)
    lines = (
        (without, WITHOUT, "without compensation"),
        (compensated, WITH, "with the learned compensator"),
    )
    if motion is MOVES:
        quantity, scale, command = "position [µm]", 1e6, without.x_cmd
    else:
        quantity, scale, command = "velocity [mm/s]", 1e3, without.v_cmd
    for run, colour, said in lines:
        values = run.x_enc if motion is MOVES else run.v["measured"]
        axes.plot(t, scale * values[part], color=colour, lw=0.7, label=said)
    axes.plot(t, scale * command[part], color=INK, lw=0.8, ls=(0, (4, 2)), label="command")
    axes.set_xlim(t[0], t[-1])
    axes.set_xlabel("Time [s]")
    axes.set_ylabel(f"Measured {quantity}")
