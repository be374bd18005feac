"""Sections on what one recording gave: parameters, the benefit of compensation, and use."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from stickslip.evaluation.guards import Benefit
from stickslip.identification.estimation import Certainty, Estimation
from stickslip.identification.fitting.identifiability import NOT_VISIBLE
from stickslip.report.learned.scales import WORDS, Scale, force_scale, parameter_scale
from stickslip.report.learned.signals import measures_friction
from stickslip.report.markup import Html, element, join, paragraph, prose, table, tile
from stickslip.report.page import Section, commands, file_list, made_with
from stickslip.report.quantity import estimated, interval, meaning, number, percentage, symbol

ERRORS = {
    "force": "{0} predicted from the motion",
    "position": "{1}, loop simulated",
    "velocity": "Velocity, loop simulated",
    "closed_loop_force": "{0}, loop simulated",
}
LEVELS = ("well known", "weakly known", "not visible")


def head(estimation: Estimation) -> Section:
    """Return what was learned: verdict, relative errors, and the table of parameters."""
    return Section(
        "", _what(estimation), _verdict(estimation), _table(estimation), _rest(estimation)
    )


def _what(estimation: Estimation) -> Html:
    recording = estimation.recording
    n, duration = len(recording.t), recording.t[-1]
    return paragraph(
        f"One recording, {recording.source}, of {number(duration, 4)} s ({number(n, 6)} samples at "
        f"{number(1.0 / recording.T_s, 4)} Hz) of a {recording.motion} drive, was searched for the "
        f"parameters of the {estimation.fit.space.law.title} model of friction"
        + ("." if measures_friction(estimation) else ", inertia and viscous friction.")
    )


def _verdict(estimation: Estimation) -> Html:
    known = estimation.known
    sentences = []
    for level in LEVELS:
        names = [symbol(name) for name in known if known[name].visible == level]
        if names:
            sentences.append(f"{level.capitalize()}: {', '.join(names)}.")
    tiles, errors = [], estimation.figures.errors()
    place, push = WORDS[estimation.recording.motion]
    push = "friction" if measures_friction(estimation) else push
    for name, what in ERRORS.items():
        error = errors[name]
        if math.isfinite(error):
            title = what.format(push.capitalize(), place.capitalize())
            tiles.append(tile(title, percentage(error), "relative error"))
    return element(
        "div",
        paragraph(" ".join(sentences)),
        element("div", join(tiles, "\n"), class_="tiles"),
        paragraph(f"Criterion: {estimation.criterion}, since {estimation.reason}."),
        *(paragraph(f"{str(fault).capitalize()}.") for fault in estimation.faults),
        class_="verdict",
    )


def _table(estimation: Estimation) -> Html:
    motion = estimation.recording.motion
    rows = [
        (
            symbol(name),
            meaning(name),
            *cells(known, parameter_scale(name, known.value, motion)),
            prose(known.sentence),
        )
        for name, known in estimation.known.items()
    ]
    return table(
        ("", "", "Learned", "95 % interval", "Unit", "How well"),
        rows,
        "Learned parameters (value ± standard error)",
        (0, 1, 4, 5),
    )


def cells(known: Certainty, scale: Scale) -> tuple[str, str, str]:
    """Return value with error, interval, and unit; what is not visible has no error."""
    value, error = scale.factor * known.value, scale.factor * known.standard_error
    sentences = (
        f"≈ {number(value, 2)}" if known.visible == "not visible" else estimated(value, error)
    )
    return sentences, interval(scale.factor * known.low, scale.factor * known.high), scale.unit


def _rest(estimation: Estimation) -> Html:
    """Return the constant force, the delay and the exponent."""
    error = estimation.errors["F_0"]
    unit = force_scale(estimation.recording.motion, np.ones(1)).unit
    push = WORDS[estimation.recording.motion][1]
    constant = f"a constant {push} of {estimated(estimation.F_0, error)} {unit}"
    if measures_friction(estimation):
        return paragraph(f"Beside friction the sensor shows {constant}.")
    late = number(1e3 * abs(estimation.delay), 3)
    when = "earlier" if estimation.delay < 0.0 else "later"
    return paragraph(
        f"Beside friction {constant} acts against positive motion, and the motor’s {push} acts "
        f"{late} ms {when} than it was logged or commanded.",
        _exponent(estimation),
    )


def _exponent(estimation: Estimation) -> str:
    """Return how friction falls with speed, where that shows."""
    if "v_s" not in estimation.known or estimation.known["v_s"].visible == NOT_VISIBLE:
        return ""
    ratio, other = "|$v$| / $v_s$", number(3.0 - estimation.delta, 1)
    power = f"({ratio})²" if estimation.delta == 2.0 else ratio
    return f" Friction falls with speed by exp(−{power}), rather than with the exponent {other}."


def compensation(benefit: Benefit) -> Section:
    """Return the section with the table of tracking errors."""
    verdict = "The error is nowhere larger than 1.02 times that without the compensator."
    if not benefit.harmless:
        verdict = f"The compensator increases the tracking error: {benefit.reason}."
    elif benefit.share < 1.0:
        verdict = f"It gives {percentage(benefit.share)} of the learned force: {benefit.reason}."
    rows = [
        (
            row.drive.replace(" x ", " × "),
            number(1e3 * row.speed, 3),
            number(1e3 * row.without, 3),
            number(1e3 * row.compensated, 3),
            number(row.ratio, 3),
        )
        for row in benefit.rows
    ]
    return Section(
        "Whether compensation helps",
        paragraph(
            "The compensator was tried on the paper’s trapezoid at the log’s speed, a tenth and a "
            f"hundredth of it, on simulated drives. {verdict}"
        ),
        table(
            ("Simulated drive", "Speed", "Without", "With", "Ratio"),
            rows,
            f"RMS tracking error, all in {benefit.unit}",
            (0,),
        ),
    )


FILES = {
    "parameters.csv": "the parameters with units and intervals, unrounded, in SI units",
    "learned.json": "the same with criterion, relative errors, seed and versions",
    "compensator.fmu": "the tuned compensator, for any tool that imports FMUs",
}


def use(estimation: Estimation, beside: Collection[str]) -> Section:
    """Return the last section.

    Parameters
    ----------
    beside : names of the files in the page's folder
    """
    exports = []
    if "learned.json" in beside:
        exports += [
            "stickslip export compensator --parameters learned.json --as fmu",
            "stickslip export compensator --parameters learned.json --as st",
        ]
    if "compensator.fmu" in beside:
        exports.append("stickslip check compensator.fmu")
    parts = [file_list({name: what for name, what in FILES.items() if name in beside})]
    if exports:
        how = "As FMU or as structured text for a PLC; --as c gives C99:"
        parts += [paragraph(how), commands(*exports)]
    return Section("Using the result", *parts, *_next(estimation), made_with())


def _next(estimation: Estimation) -> list[Html]:
    """Return how to identify the parameters better that are not well identified."""
    vague = [name for name, known in estimation.known.items() if known.visible != "well known"]
    if not vague:
        return []
    motion = " --motion rotary" if estimation.recording.motion == "rotary" else ""
    return [
        paragraph(
            "Another experiment can identify these parameters better: this command plans one. A "
            "compensator with poorly identified parameters may push where there is no friction."
        ),
        commands(f"stickslip plan --show {' '.join(vague)}{motion} --out next.csv"),
    ]
