"""The page's head: which parameters are known, and how well."""

from __future__ import annotations

import math

import numpy as np

from stickslip.identification.estimation import Certainty, Estimation
from stickslip.identification.fitting.identifiability import NOT_VISIBLE
from stickslip.report.learned.parts import measures_friction
from stickslip.report.learned.scales import (
    WORDS,
    Scale,
    force_scale,
    parameter_scale,
)
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    symbol,
    table,
)
from stickslip.report.quantity import (
    MEANINGS,
    estimated,
    interval,
    number,
)
from stickslip.report.shown import parameter

ERRORS = {
    "force": "{0} that the motion implies",
    "position": "{1}, loop simulated",
    "velocity": "Velocity, loop simulated",
    "closed_loop_force": "{0}, loop simulated",
}
LEVELS = ("well known", "weakly known", "not visible")


def write(estimation: Estimation) -> Html:
    """Return what was learned: verdict, relative errors, and the table of parameters."""
    return join([_what(estimation), _verdict(estimation), _table(estimation), _rest(estimation)])


def _what(estimation: Estimation) -> Html:
    recording = estimation.recording
    n, duration = len(recording.t), recording.t[-1]
    return paragraph(
        f"One recording, {recording.source}, of {number(duration, 4)} s ({number(n, 6)} samples at "
        f"{number(1.0 / recording.T_s, 4)} Hz) of a {recording.motion} drive, was searched for the "
        "parameters of the LuGre model of friction"
        + ("." if measures_friction(estimation) else ", inertia and viscous friction.")
    )


def _verdict(estimation: Estimation) -> Html:
    known = estimation.known
    said = []
    for level in LEVELS:
        names = [parameter(name) for name in known if known[name].visible == level]
        if names:
            said.append(join([f"{level[:1].upper()}{level[1:]}: ", join(names, ", "), "."]))
    tiles, errors = [], estimation.figures.errors()
    place, push = WORDS[estimation.recording.motion]
    push = "friction" if measures_friction(estimation) else push
    for name, what in ERRORS.items():
        error = errors[name]
        if math.isfinite(error):
            tile = (
                element("span", what.format(push.capitalize(), place.capitalize()), class_="name"),
                element("span", relative(error), class_="value"),
                element("span", "relative error", class_="beside"),
            )
            tiles.append(element("div", *tile, class_="tile"))
    return element(
        "div",
        paragraph(join(said, " ")),
        element("div", join(tiles, "\n"), class_="tiles"),
        paragraph(f"Judged by the {estimation.judge}: {estimation.reason}."),
        *(paragraph(f"{str(fault).capitalize()}.") for fault in estimation.faults),
        class_="verdict",
    )


def relative(error: float) -> str:
    """Return a relative error in per cent, to three digits."""
    return f"{number(100.0 * error, 3)}\u00a0%"


def _table(estimation: Estimation) -> Html:
    motion = estimation.recording.motion
    rows = [
        (
            parameter(name),
            MEANINGS[name],
            *shown(known, parameter_scale(name, known.value, motion)),
            element("span", known.sentence.replace("+-", "±"), class_="prose"),
        )
        for name, known in estimation.known.items()
    ]
    return table(
        ("", "", "Learned", "95 % interval", "Unit", "How well"),
        rows,
        "Learned parameters (value ± standard error)",
        (0, 1, 4, 5),
    )


def shown(known: Certainty, scale: Scale) -> tuple[str, str, str]:
    """Return value with error, interval, and unit; what is not visible has no error."""
    value, error = scale.factor * known.value, scale.factor * known.standard_error
    said = f"≈ {number(value, 2)}" if known.visible == "not visible" else estimated(value, error)
    return said, interval(scale.factor * known.low, scale.factor * known.high), scale.unit


def _rest(estimation: Estimation) -> Html:
    """Return what else the fit found."""
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


def _exponent(estimation: Estimation) -> Html:
    """Return how friction falls with speed, where that shows."""
    if estimation.known["v_s"].visible == NOT_VISIBLE:
        return join([])
    ratio = join(["|", symbol("v"), "| / ", symbol("v", "s")])
    power = join(["(", ratio, ")", element("sup", "2")]) if estimation.delta == 2.0 else ratio
    other = number(3.0 - estimation.delta, 1)
    return join(
        [" Friction falls with speed by exp(−", power, f"), rather than with the exponent {other}."]
    )
