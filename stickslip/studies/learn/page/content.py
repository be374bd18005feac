"""Sections on what one recording gave: parameters, evaluation, fit, compensation, and use."""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import partial
from itertools import groupby

import numpy as np

from stickslip.identification.criteria.known_loop import OutputError, is_running
from stickslip.identification.estimation import Estimation
from stickslip.identification.fitting.identifiability import IDENTIFIABLE, LEVELS, NOT_IDENTIFIABLE
from stickslip.logs import Finding
from stickslip.presentation.markup import Html, element, join, paragraph, prose, table, tile
from stickslip.presentation.page import Illustration, Section, commands, file_list, made_with
from stickslip.presentation.quantity import (
    number,
    percentage,
    symbol,
    with_error,
)
from stickslip.presentation.scale import WORDS, force_scale, velocity_scale
from stickslip.studies.learn import tables
from stickslip.studies.learn.page.figures import (
    draw_correlations,
    draw_force,
    draw_profiles,
    draw_recording,
    draw_residual,
    unresolved,
)
from stickslip.studies.learn.page.signals import (
    measures_friction,
    residual,
    simulated_position,
    steady_name,
)
from stickslip.studies.learn.page.stretches import stretches
from stickslip.thresholds import harm, offer
from stickslip.trial.candidates import CompensatorComparison
from stickslip.trial.guards import Benefit
from stickslip.trial.observed import ObserverTrial

ERRORS = {
    "force": "{0} predicted from the motion",
    "position": "{1}, loop simulated",
    "velocity": "Velocity, loop simulated",
    "closed_loop_force": "{0}, loop simulated",
}
RELATIVE = "Tracking error of the simulated drives relative to that without compensation"


def head(estimation: Estimation) -> Section:
    """Return the head of the page: of which recording what was learned."""
    return Section("", _what(estimation))


def learned(estimation: Estimation) -> Section:
    """Return what was learned: verdict, relative errors, and the table of parameters."""
    title = "Learned parameters"
    table_of = tables.parameters(estimation).html(f"{title} (value ± standard error)")
    return Section(title, _verdict(estimation), table_of, _rest(estimation))


def _what(estimation: Estimation) -> Html:
    recording = estimation.recording
    n, duration = len(recording.t), recording.t[-1]
    return paragraph(
        f"One recording, {recording.source}, of {number(duration, 4)} s ({number(n, 6)} samples at "
        f"{number(1.0 / recording.T_s, 4)} Hz) of a {recording.motion} drive, was searched for the "
        f"parameters of the {estimation.law.title} model of friction"
        + ("." if measures_friction(estimation) else ", inertia and viscous friction.")
    )


def _verdict(estimation: Estimation) -> Html:
    known = estimation.known
    sentences = []
    for level in LEVELS:
        names = [symbol(name) for name in known if known[name].identifiability == level]
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
        *(paragraph(f"{str(fault)[:1].upper()}{str(fault)[1:]}.") for fault in estimation.faults),
        class_="verdict",
    )


def _rest(estimation: Estimation) -> Html:
    """Return the constant force, the delay and the exponent."""
    error = estimation.fitted.errors["F_0"]
    unit = force_scale(estimation.recording.motion, np.ones(1)).unit
    push = WORDS[estimation.recording.motion][1]
    constant = f"a constant {push} of {with_error(estimation.F_0, error)} {unit}"
    if measures_friction(estimation):
        return paragraph(f"In addition to friction the sensor shows {constant}.")
    late = number(1e3 * abs(estimation.delay), 3)
    when = "earlier" if estimation.delay < 0.0 else "later"
    return paragraph(
        f"In addition to friction, {constant} acts against positive motion, and the motor’s {push} "
        f"acts {late} ms {when} than it was logged or commanded.",
        _exponent(estimation),
    )


def _exponent(estimation: Estimation) -> str:
    """Return how friction falls with speed, where that shows."""
    delta = estimation.chosen.get("delta")
    if delta is None or estimation.known["v_s"].identifiability == NOT_IDENTIFIABLE:
        return ""
    ratio, other = "|$v$| / $v_s$", number(3.0 - delta, 1)
    power = f"({ratio})²" if delta == 2.0 else ratio
    return f" Friction falls with speed by exp(−{power}), rather than with the exponent {other}."


def compensation(
    benefit: Benefit,
    observed: ObserverTrial | None = None,
    compared: CompensatorComparison | None = None,
) -> Section:
    """Return the section with the table of tracking errors, and what other parts leave."""
    verdict = f"The error is nowhere larger than {harm.WORSE:g} times that without the compensator."
    if not benefit.acceptable:
        verdict = f"The compensator increases the tracking error: {benefit.reason}."
    elif benefit.share < 1.0:
        verdict = f"It gives {percentage(benefit.share)} of the learned force: {benefit.reason}."
    shown_tables = []
    for figure, shown in benefit.tables().items():
        factor, unit = benefit.shown(shown[0])
        what = "tracking" if len(shown) == len(benefit.rows) else figure
        commands = dict.fromkeys(row.command for row in shown)
        rows = [
            (
                drive.replace(" x ", " × ").replace("+-", "±"),
                *(
                    f"{number(factor * row.without, 3)} → {number(factor * row.compensated, 3)}"
                    for row in of
                ),
            )
            for drive, of in groupby(shown, key=lambda row: row.drive)
        ]
        title = f"RMS {what} error without → with the compensator, in {unit.replace('um', 'µm')}"
        shown_tables.append(table(("Simulated drive", *commands), rows, title, (0,)))
    return Section(
        "Whether compensation helps",
        paragraph(
            "The compensator was tried on a family of simulated drives that the log supports: the "
            "friction as fitted, plausible values around it, the ends of the intervals of what is "
            "poorly identified, half the friction and half as much again, friction that differs by "
            "direction and position, and, where its law does not explain the log, other laws. "
            "Commands are the paper’s trapezoid at the log’s speed, a tenth and a hundredth of it, "
            f"moves of a few presliding deflections, and short moves. {verdict}"
        ),
        *shown_tables,
        *(_compared(compared) if compared else _observer(observed) if observed else ()),
    )


def _compared(compared: CompensatorComparison) -> list[Html]:
    """Return what each compensator leaves of the error of none."""
    return [
        paragraph(
            f"Compensators that were tried on the same drives: {compared.sentence}. The peak"
            f" sensitivity $M_s$ of the loop is the largest for all masses that the log"
            f" allows; with an observer, at most {offer.SENSITIVITY:g}."
        ),
        tables.compensators(compared).html(RELATIVE),
    ]


def _observer(observed: ObserverTrial) -> list[Html]:
    """Return what feedforward, disturbance observer and both leave of the error of none."""
    if observed.designed is None:
        return [paragraph(f"There is {observed.reason}.")]
    designed = observed.designed
    share = dict(designed.observer.values)["share"]
    return [
        paragraph(
            "A disturbance observer estimates from encoder and motor force what the feedforward "
            "leaves, without a model of friction, and compensates "
            f"{percentage(share)} of it. It is feedback: with it the peak "
            f"sensitivity of the loop is {number(designed.sensitivity, 3)} instead of "
            f"{number(designed.without, 3)}, at most {offer.SENSITIVITY:g} for all masses that the "
            f"log allows. Recommended: {observed.recommended or 'none of them'}."
        ),
        tables.parts(observed).html(RELATIVE),
    ]


FILES = {
    "parameters.csv": "the parameters with units and intervals, unrounded, in SI units",
    "learned.json": "the same with criterion, relative errors, seed and versions",
    "compensator.fmu": "the tuned compensator, from the controller's commands to the force to add",
    "observer.fmu": "the disturbance observer, to be added after the compensator",
}


def use(estimation: Estimation, beside: Collection[str], *, forced: bool = False) -> Section:
    """Return the last section.

    Parameters
    ----------
    beside : names of the files in the page's folder
    forced : whether what is refused was written
    """
    exports, force = [], " --force" if forced else ""
    if "compensator.fmu" in beside and "learned.json" in beside:
        exports += [
            f"stickslip export compensator --parameters learned.json --as {form}{force}"
            for form in ("fmu", "st")
        ]
    if "observer.fmu" in beside:
        exports.append(f"stickslip export observer --parameters learned.json --as st{force}")
    if "compensator.fmu" in beside:
        exports.append("stickslip check compensator.fmu")
    parts = [file_list({name: what for name, what in FILES.items() if name in beside})]
    if exports:
        how = "As FMU or as structured text for a PLC; --as c gives C99:"
        parts += [paragraph(how), commands(*exports)]
    return Section("Using the result", *parts, *_next(estimation), made_with())


def _next(estimation: Estimation) -> list[Html]:
    """Return how to identify the parameters better that are not well identified."""
    vague = [
        name for name, known in estimation.known.items() if known.identifiability != IDENTIFIABLE
    ]
    if not vague:
        return []
    motion = " --motion rotary" if estimation.recording.rotary else ""
    return [
        paragraph(
            "Another experiment can identify these parameters better: this command plans one. A "
            "compensator with poorly identified parameters may push where there is no friction."
        ),
        commands(f"stickslip plan --show {' '.join(vague)}{motion} --out next.csv"),
    ]


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
                f" The residual is {number(estimation.model_error, 2)} times what encoder steps "
                "and noise explain; up to 2 is good."
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
    searches, algorithm = estimation.searches.table, estimation.searches.algorithm
    evaluations = number(float(searches["evaluations"].sum()), 7)
    title, stopped = algorithm.title, algorithm.stopped
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


STANDING_OUT = 5
"""Stretches of the residual that are named."""
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
        _standing_out(estimation),
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
        Illustration(
            "correlations",
            partial(draw_correlations, estimation),
            "Correlations between the errors of the parameters",
            "Correlations between the errors of the estimated values. Where one is near 1 or −1, "
            "the recording shows a combination of two values better than either of them.",
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
        f"inertia and constant force, beside the learned {steady_name(estimation)} with viscous "
        "friction; soon after a reversal bristles still bend, and friction is not on the curve.",
    )


def _residual_figure(estimation: Estimation) -> Illustration:
    place, push = WORDS[estimation.recording.motion]
    if simulated_position(estimation) is None:
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
        f"Difference of the {left}, over time, {place} and velocity, and its spectrum",
        f"{what}. A pattern over {place} indicates ripple or friction that depends on the {place}, "
        "one over velocity of friction that the model does not describe. A peak in (d) is a "
        "resonance or a periodic disturbance.",
    )


def _standing_out(estimation: Estimation) -> Html:
    """Return where the residual stands out, the largest stretches."""
    found = residual(estimation)
    outliers = stretches(found.t, found.values, found.velocity)
    if not outliers:
        return paragraph("The residual stands out nowhere.")
    speeds = velocity_scale(estimation.recording.motion, found.velocity)
    items = [
        element(
            "li",
            f"{number(one.begin, 4)} to {number(one.end, 4)} s: up to"
            f" {number(found.scale.factor * one.peak, 2)} {found.scale.unit},"
            f" {number(one.ratio, 2)} times the largest usual value, at"
            f" {number(speeds.factor * one.speed, 2)} {speeds.unit}",
        )
        for one in outliers[:STANDING_OUT]
    ]
    more = len(outliers) - len(items)
    head = "The residual stands out here, where the learned drive does not explain the recording:"
    rest = [paragraph(f"And in {more} smaller stretches.")] if more else []
    return join([paragraph(head), element("ul", join(items, "\n")), *rest])


def _profiles(estimation: Estimation) -> str:
    names = unresolved(estimation)
    sentence = "Profile likelihoods, at up to three standard errors on either side."
    if names:
        sentence += (
            f" Not drawn for {', '.join(map(symbol, names))}: at a bound, or where the others "
            "could not follow, there is no curve."
        )
    return sentence
