"""The folder and the page of another log against a learned drive."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from stickslip.catalog.parameters import Values
from stickslip.identification.criteria.motion import position_of
from stickslip.learned.file import LearnedFile
from stickslip.presentation import style
from stickslip.presentation.page import MADE_WITH, Section, picture_files, write_page
from stickslip.presentation.quantity import percentage
from stickslip.presentation.scale import WORDS as PLACES
from stickslip.presentation.scale import Scale, force_scale, position_scale, thinned
from stickslip.servo.measurement import Array
from stickslip.storage import staged
from stickslip.storage.writing import write_tables
from stickslip.studies.validate import tables
from stickslip.studies.validate.log_prediction import LogPrediction
from stickslip.studies.validate.log_verdict import verdict
from stickslip.studies.validate.tables import signal_title

FILES = (
    *("prediction.csv", "changes.csv", "spans.csv", "report.html"),
    *picture_files(["prediction"]),
)
"""What ``write_log_validation`` writes."""


def write_log_validation(
    found: LogPrediction,
    learned: LearnedFile,
    controller: str,
    folder: Path,
    command: Mapping[str, object],
) -> None:
    """Write the errors of a log's signals, what has changed, errors over the log, and the page."""
    frames = {
        "prediction": tables.signals(found).frame(),
        "changes": tables.changes(found, learned.drive).frame(),
        "spans": tables.spans(found).frame(),
    }
    sections = log_sections(found, learned.drive, learned.path.name, controller)
    with staged(folder, command) as staging:
        write_tables(frames, staging)
        title = f"{learned.path.name} against the log {found.recording.source}"
        write_page(staging, title, sections)


def log_sections(
    found: LogPrediction, values: Values, learned: str, controller: str
) -> list[Section]:
    """Return the sections, from the values of the learned drive and the name of its file."""
    motion = found.recording.motion
    errors = [
        (signal_title(name, motion), percentage(one.relative), "relative error")
        for name, one in found.signals.items()
    ]
    return [
        Section(
            "",
            "studies/validate/page/head.j2",
            recording=found.recording,
            verdict=verdict(found, values),
            errors=errors,
            learned=learned,
            controller=controller,
        ),
        Section(
            "Recorded and predicted",
            "studies/validate/page/prediction.j2",
            {"prediction": partial(draw_prediction, found)},
            signals=tables.signals(found),
            loop=found.goodness.simulated is not None,
        ),
        Section(
            "What has changed",
            "<p>Changes of the learned drive that explain what the force leaves best. They are not "
            "applied; an interval that contains 0 shows no change.</p>"
            "{{ changes.html('Against the learned drive') }}",
            changes=tables.changes(found, values),
        ),
        Section(
            "Over the log",
            "{{ spans.html('Errors in each part of the log') }}",
            spans=tables.spans(found),
        ),
        MADE_WITH,
    ]


def draw_prediction(found: LogPrediction) -> Figure:
    """Draw force and errors over time."""
    fit, motion = found.goodness, found.recording.motion
    t, spans = fit.t, found.spans
    inside = (t >= spans["begin"].iloc[0]) & (t <= spans["end"].iloc[-1])
    left = (fit.measured - fit.predicted)[inside]
    rows = 2 + int(fit.simulated is not None)
    figure = style.new_figure(style.PAGE, 38.0 * rows + 12.0)
    panels = figure.subplots(rows, 1, sharex=True)
    style.zero_lines(*panels)
    push = PLACES[motion][1].capitalize()
    scale = force_scale(motion, fit.measured[inside])

    def line(row: int, signal: Array, scale: Scale, **look: object) -> None:
        panels[row].plot(*thinned(t[inside], scale.factor * signal), **look)

    line(0, fit.measured[inside], scale, color=style.WITHOUT, lw=1.4, alpha=0.7, label="measured")
    line(0, fit.predicted[inside], scale, color=style.WITH, lw=0.6, label="predicted")
    panels[0].set_ylabel(f"{push} [{scale.unit}]")
    style.name_panel(panels[0], "a", f"{push}, measured and predicted from the measured motion")
    fine = force_scale(motion, left)
    line(1, left, fine, color=style.WITH, lw=0.5)
    edges = [*spans["begin"], spans["end"].iloc[-1]]
    panels[1].stairs(
        fine.factor * spans["force_bias"], edges, baseline=None, color=style.WITHOUT, lw=1.6,
        label="mean in the direction of motion",
    )  # fmt: skip
    panels[1].legend(loc="upper right")
    panels[1].set_ylabel(f"Error [{fine.unit}]")
    style.name_panel(panels[1], "b", f"{push}, measured less predicted")
    if fit.simulated is not None:
        error = (position_of(found.recording) - fit.simulated)[inside]
        shown = position_scale(motion, error)
        line(2, error, shown, color=style.WITH, lw=0.5)
        panels[2].set_ylabel(f"Error [{shown.unit}]")
        place = PLACES[motion][0].capitalize()
        style.name_panel(panels[2], "c", f"{place}, measured less that of the simulated loop")
    panels[-1].set(xlabel="Time [s]", xlim=t[inside][[0, -1]])
    panels[0].legend(loc="upper right", ncols=2)
    figure.align_ylabels()
    return figure
