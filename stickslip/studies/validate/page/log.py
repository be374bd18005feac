"""Sections on another log against a learned drive."""

from __future__ import annotations

from functools import partial

from matplotlib.figure import Figure

from stickslip.catalog.parameters import Values, unit_of
from stickslip.identification.criteria.motion import position_of
from stickslip.presentation import style
from stickslip.presentation.markup import element, join, paragraph, quiet, table, tile
from stickslip.presentation.page import Illustration, Section, made_with
from stickslip.presentation.quantity import interval, number, percentage
from stickslip.presentation.quantity import unit as printed
from stickslip.presentation.scale import WORDS as PLACES
from stickslip.presentation.scale import Scale, force_scale, position_scale, thinned
from stickslip.servo.measurement import Array
from stickslip.studies.validate import tables
from stickslip.studies.validate.log_prediction import FRICTION, LogPrediction
from stickslip.studies.validate.log_verdict import WORDS, verdict
from stickslip.studies.validate.tables import signal_scale, signal_title

FIGURES = ("prediction",)


def log_sections(
    found: LogPrediction, values: Values, learned: str, controller: str
) -> list[Section]:
    """Return the sections.

    Parameters
    ----------
    values : of the learned drive by name
    learned : name of the file of the learned drive
    controller : that of the log, for people
    """
    return [
        _head(found, values, learned, controller),
        _signals(found),
        _changes(found, values),
        _spans(found),
        Section("Made with", made_with()),
    ]


def _head(found: LogPrediction, values: Values, learned: str, controller: str) -> Section:
    first, *reasons = (f"{text[:1].upper()}{text[1:]}." for text in verdict(found, values))
    tiles = [
        tile(signal_title(name, found.recording.motion), percentage(one.relative), "relative error")
        for name, one in found.signals.items()
    ]
    recording = found.recording
    return Section(
        "",
        paragraph(
            f"{number(recording.t[-1], 4)} s of {recording.source} against the drive of {learned}, "
            f"of which nothing was fitted again. Controller: {controller}."
        ),
        element(
            "div",
            paragraph(first),
            element("div", join(tiles, "\n"), class_="tiles"),
            *(paragraph(reason.replace("+-", "±")) for reason in reasons),
            class_="verdict",
        ),
    )


def _signals(found: LogPrediction) -> Section:
    return Section(
        "Recorded and predicted",
        Illustration(
            "prediction",
            partial(draw_prediction, found),
            "Recorded and predicted force over time, and the errors of force and position",
            "(a) Force of the log, measured, and predicted from its motion by the learned drive; "
            "(b) their difference, and its mean in the direction of motion in each part of the log"
            + (
                "; (c) position of the log less that of the simulated loop."
                if _loop(found)
                else "."
            ),
        ),
        tables.signals(found).html("Root mean square of recorded less predicted"),
        quiet(
            "Noise: what noise and the steps of encoder and force make, from simulated logs. "
            "Intervals: at most what the standard errors of the parameters make. Ratio: of the "
            "error to both; up to 2 is explained."
        ),
    )


def _loop(found: LogPrediction) -> bool:
    return found.goodness.simulated is not None


def _changes(found: LogPrediction, values: Values) -> Section:
    rotary, rows = found.recording.rotary, []
    for name, change in found.changes.items():
        if name in ("m", FRICTION):
            factor, unit = 100.0 / (values["m"] if name == "m" else 1.0), "%"
        else:
            factor, unit = 1.0, printed(unit_of("b" if name == "b" else "F_c", rotary=rotary))
        ends = interval(factor * change.low, factor * change.high)
        rows.append((WORDS[name].capitalize(), number(factor * change.value, 3), ends, unit))
    return Section(
        "What has changed",
        paragraph(
            "Changes of the learned drive that explain what the force leaves best. They are not "
            "applied; an interval that contains 0 shows no change."
        ),
        table(("", "Change", "95 % interval", "Unit"), rows, "Against the learned drive", (0, 3)),
    )


def _spans(found: LogPrediction) -> Section:
    motion, table_of = found.recording.motion, found.spans
    names = list(table_of.columns[2:])
    titles = {
        "force_bias": "Force, mean error in the direction of motion",
        "force_error": "Force, RMS error",
        "position_error": f"{PLACES[motion][0].capitalize()}, RMS error",
    }
    scales = {name: signal_scale(motion, name, float(table_of[name].abs().max())) for name in names}
    rows = [
        (
            f"{number(row['begin'], 3)} to {number(row['end'], 3)}",
            *(number(scales[name].factor * row[name], 3) for name in names),
        )
        for row in table_of.to_dict("records")
    ]
    head = ("Time [s]", *(f"{titles[name]} [{scales[name].unit}]" for name in names))
    return Section("Over the log", table(head, rows, "Errors in each part of the log"))


def draw_prediction(found: LogPrediction) -> Figure:
    """Draw force and errors over time."""
    fit, motion = found.goodness, found.recording.motion
    t, spans = fit.t, found.spans
    inside = (t >= spans["begin"].iloc[0]) & (t <= spans["end"].iloc[-1])
    left = (fit.measured - fit.predicted)[inside]
    rows = 2 + int(_loop(found))
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
