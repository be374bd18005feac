"""The folder and the page of a log with the compensator running against one without."""

from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from stickslip.evaluation.tracking import NONE
from stickslip.learned.file import LearnedFile
from stickslip.presentation import style
from stickslip.presentation.page import MADE_WITH, Section, picture_files, write_page
from stickslip.presentation.quantity import number
from stickslip.presentation.scale import WORDS, thinned, velocity_scale
from stickslip.storage import staged
from stickslip.storage.writing import write_tables
from stickslip.studies.learn.page.tracking import LOOKS
from stickslip.studies.learn.tables import tracking_scales
from stickslip.studies.validate import tables
from stickslip.studies.validate.compared_logs import LogComparison, sentences

FIGURE = "comparison"
FILES = ("tracking.csv", "report.html", *picture_files([FIGURE]))
"""What ``write_comparison`` writes."""


def write_comparison(
    found: LogComparison, logs: tuple[str, str], learned: LearnedFile, controller: str, folder: Path
) -> None:
    """Write the tracking errors of two logs, without and with the compensator, and the page."""
    sections = comparison_sections(found, logs, learned.path.name, controller)
    command = {"name": "validate", "without": logs[0], "log": logs[1]}
    with staged(folder, command) as staging:
        write_tables({"tracking": tables.tracking(found).frame()}, staging)
        write_page(staging, f"{logs[1]} against {logs[0]}: what the compensator brought", sections)


def comparison_sections(
    found: LogComparison, logs: tuple[str, str], learned: str, controller: str
) -> list[Section]:
    """Return the sections, from the names of the logs and of the file of the drive."""
    head = Section(
        "",
        "<p>Tracking errors of {{ logs[1] }}, recorded with the compensator running, and of "
        "{{ logs[0] }}, recorded without it, where both had the same command: {{ seconds }} s.</p>"
        '<div class="verdict">{% for text in sentences %}<p>{{ text | sentence }}</p>{% endfor %}'
        "</div>",
        logs=logs,
        seconds=number(sum(run.n for run in found.stretches) * float(found.t[1] - found.t[0]), 3),
        sentences=sentences(found),
    )
    errors = Section(
        "Tracking errors without and with the compensator",
        "studies/validate/page/comparison.j2",
        {FIGURE: partial(draw_comparison, found)},
        tracking=tables.tracking(found),
        found=found,
        n=found.parts,
        learned=learned,
        controller=controller,
    )
    return [head, errors, MADE_WITH]


def draw_comparison(found: LogComparison) -> Figure:
    """Draw command and errors over time: measured on the left, simulated on the right."""
    kinds, motion = list(tables.kinds(found)), found.motion
    figure = style.new_figure(style.PAGE if len(kinds) > 1 else 1.3 * style.COLUMN, 120.0)
    panels = figure.subplots(3, len(kinds), sharex=True, sharey="row", squeeze=False)
    gaps = np.flatnonzero(np.diff(found.t) > 1.5 * (found.t[1] - found.t[0])) + 1
    place = WORDS[motion][0].capitalize()
    command = velocity_scale(motion, found.v_cmd)
    v_scale, x_scale = tracking_scales(found.measured.errors[NONE], motion)
    for column, (kind, one) in enumerate(kinds):
        axes = panels[:, column]
        style.zero_lines(*axes)
        for part in np.split(np.arange(len(found.t)), gaps):
            t = found.t[part]
            axes[0].plot(*thinned(t, command.factor * found.v_cmd[part]), color=style.INK, lw=0.8)
            for name, colour in LOOKS.items():
                look = {"color": colour, "lw": 0.7, "label": name if part[0] == 0 else None}
                axes[1].plot(*thinned(t, v_scale.factor * one.velocity[name][part]), **look)
                axes[2].plot(*thinned(t, x_scale.factor * one.position[name][part]), **look)
        titles = ("Velocity command", f"Velocity error, {kind}", f"{place} error, {kind}")
        for row, title in enumerate(titles):
            style.name_panel(axes[row], "abcdef"[3 * column + row], title)
        axes[2].set(xlabel="Time [s]", xlim=found.t[[0, -1]])
    for row, (what, scale) in enumerate(
        (("Velocity", command), ("Error", v_scale), ("Error", x_scale))
    ):
        panels[row, 0].set_ylabel(f"{what} [{scale.unit}]")
    style.legend_below(panels[1, 0])
    figure.align_ylabels(panels[:, 0])
    return figure
