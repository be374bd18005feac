"""Sections on how one recording was evaluated: the log, the criterion, and the fit."""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import partial

from stickslip.identification.controller.initial_state import is_running
from stickslip.identification.criteria.output_error import OutputError
from stickslip.identification.estimation import Estimation
from stickslip.logs import Finding
from stickslip.report.learned.figures import draw_force, draw_recording, draw_residual
from stickslip.report.learned.profiles import draw_profiles, unresolved
from stickslip.report.learned.scales import WORDS
from stickslip.report.learned.signals import measures_friction
from stickslip.report.markup import Html, join, paragraph, prose, table
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import number, percentage, symbol

MEANT = {
    "force": "{0}, recorded against predicted from the recorded motion, both low-passed",
    "force_unfiltered": "The same, recorded signal as it is",
    "position": "{1}, recorded against simulated in the closed loop",
    "velocity": "Velocity, differences of the same signals",
    "closed_loop_force": "{0}, recorded against commanded in the simulated loop",
}


def criterion(estimation: Estimation) -> Section:
    """Return the section on the criterion, the errors and the search."""
    errors = estimation.figures.errors()
    place, push = WORDS[estimation.recording.motion]
    words = ("Friction" if measures_friction(estimation) else push.capitalize(), place.capitalize())
    rows = [
        (MEANT[name].format(*words), percentage(errors[name]))
        for name in MEANT
        if math.isfinite(errors[name])
    ]
    return Section(
        "How candidates were evaluated",
        _criterion(estimation),
        _controller(estimation),
        table(
            ("Root mean square of the difference over that of the recorded signal", ""),
            rows,
            "Relative errors of the learned drive",
        ),
        *_search(estimation),
    )


def _criterion(estimation: Estimation) -> Html:
    place, push = WORDS[estimation.recording.motion]
    if estimation.criterion == OutputError.name:
        sentence = (
            "The controller ran again with the recorded commands, on a drive with each candidate’s "
            f"parameters; the differences between recorded and simulated {place} were whitened and "
            "the sum of their squares minimized. Simulated recordings with the same encoder steps "
            "and as much noise then gave the bias, which was subtracted, and the standard errors."
        )
        if math.isfinite(estimation.model_error):
            sentence += (
                f" The residual is {number(estimation.model_error, 2)} times what steps and noise "
                "explain (at most 2 is good)."
            )
        return paragraph(sentence)
    predicted = f"recorded motion predicts the {push} $m$ $a$ + $b$ $v$ +"
    if measures_friction(estimation):
        predicted = "recorded velocity predicts the friction"
    return paragraph(
        f"The {predicted} $F_f$($v$) + $F_0$, where the compensator FMU gives $F_f$; its "
        "difference from the recorded one, both through the same low-pass, was squared and "
        "minimized. Standard errors allow for errors that persist from sample to sample.",
    )


def _controller(estimation: Estimation) -> Html:
    check, push = estimation.controller, WORDS[estimation.recording.motion][1]
    if check is None or not math.isfinite(check.error):
        return join([])
    samples = "sample" if check.shift == 1 else "samples"
    form = f", its {check.form}," if check.form else ""
    late = f", {check.shift} {samples} late" if check.shift else ""
    running = " It was already running when the log began." if is_running(check.gains) else ""
    return paragraph(
        f"Along the recorded motion the controller given{form} commands the recorded {push}{late}, "
        f"with a relative error of {percentage(check.error)}.{running}"
    )


def _search(estimation: Estimation) -> list[Html]:
    searches = estimation.searches
    evaluations = number(float(searches["evaluations"].sum()), 7)
    title, stopped = estimation.algorithm.title, estimation.algorithm.stopped
    times = "1 search" if len(searches) == 1 else f"{len(searches)} searches"
    sentence = paragraph(
        f"{title[:1].upper()}{title[1:]} searched by the inverse model, {evaluations} candidates "
        f"in {times}, and least squares finished." + (f" It ended: {stopped}." if stopped else "")
    )
    if len(searches) == 1:
        return [sentence]
    names = estimation.fit.space.friction
    rows = [
        (str(row["seed"]), number(row["cost"], 4), *(number(row[name], 4) for name in names))
        for row in searches.to_dict("records")
    ]
    head = ("Seed", "Cost", *map(symbol, names))
    return [sentence, table(head, rows, "Spread over seeds, by the inverse model, in SI units")]


ORDER = ("error", "warning", "note")


def log(estimation: Estimation, findings: Collection[Finding]) -> Section:
    """Return the section on the log, errors and warnings first."""
    done = (Finding("note", remark) for remark in estimation.remarks)
    faults = (fault for fault in estimation.faults if fault not in findings)
    ordered = sorted([*findings, *faults, *done], key=lambda finding: ORDER.index(finding.severity))
    rows = [
        (finding.severity, prose(finding.what), prose(finding.figure), prose(finding.advice))
        for finding in ordered
    ]
    head = ("", "What", "Figure", "Advice")
    return Section(
        "The recording",
        table(head, rows, "What reading and checks found", (0, 1, 2, 3))
        if rows
        else paragraph("Reading and checks found nothing."),
        Illustration(
            "recording",
            partial(draw_recording, estimation),
            "Position, velocity and force of the recording over time",
            f"{estimation.recording.source}, on an even grid. Velocity is the derivative of the "
            "position through a low-pass without phase lag.",
        ),
    )


def fit(estimation: Estimation) -> Section:
    """Return the section on the fit."""
    return Section(
        "The learned drive against the recording",
        _force_figure(estimation),
        _residual_figure(estimation),
    )


def identifiability(estimation: Estimation) -> Section:
    """Return the section on how well the recording identifies each parameter."""
    return Section(
        "How well each parameter is identified",
        paragraph(
            "A profile holds one parameter at a value and lets all others follow; its deviance is "
            "twice the loss of log likelihood. Where it stays below 3.84 lies a 95 % interval. A "
            "flat profile means that the recording does not identify the parameter."
        ),
        Illustration(
            "profiles",
            partial(draw_profiles, estimation),
            "Profile likelihoods of the parameters of friction",
            _profiles(estimation),
        ),
    )


def _force_figure(estimation: Estimation) -> Illustration:
    error = percentage(estimation.figures.force)
    if measures_friction(estimation):
        return Illustration(
            "force",
            partial(draw_force, estimation),
            "Friction over position in loops, and over time, recorded and learned",
            f"(a) Friction over position, recorded and learned, relative error {error}. "
            "The learned loop begins with bristles at rest. (b), (c) The same over time, and its "
            "difference.",
        )
    push = WORDS[estimation.recording.motion][1]
    return Illustration(
        "force",
        partial(draw_force, estimation),
        "Recorded and predicted force over time, its difference, and friction over velocity",
        f"(a), (b) The recorded {push} and the one that the learned parameters predict "
        f"from the recorded motion, relative error {error}. (c), (d) Recorded {push} without "
        "inertia and constant force, beside the learned Stribeck curve with viscous friction; soon "
        "after a reversal bristles still bend, and friction is not on the curve.",
    )


def _residual_figure(estimation: Estimation) -> Illustration:
    place, push = WORDS[estimation.recording.motion]
    if estimation.figures.simulated is None:
        left = "friction" if measures_friction(estimation) else push
        what = f"Recorded less predicted {left}"
    else:
        error = percentage(estimation.figures.position)
        what, left = (
            f"Recorded less simulated {place}: the controller and the learned drive ran with the "
            f"recorded commands, relative error {error}",
            place,
        )
    return Illustration(
        "residual",
        partial(draw_residual, estimation),
        f"Difference of the {left}, over time, {place} and velocity",
        f"{what}. A pattern over {place} indicates ripple or friction that depends on the {place}, "
        "one over velocity of friction that the model does not describe.",
    )


def _profiles(estimation: Estimation) -> str:
    names = unresolved(estimation)
    sentence = "Profile likelihoods, at up to three standard errors on either side."
    if names:
        sentence += (
            f" Not drawn for {', '.join(map(symbol, names))}: at a bound, or where the others "
            "could not follow, there is no curve."
        )
    return sentence
