"""How candidates were judged, and why so."""

from __future__ import annotations

import math

from stickslip.catalog.parameters import LUGRE
from stickslip.identification.controller.initial_state import is_running
from stickslip.identification.criteria.output_error import OutputError
from stickslip.identification.estimation import Estimation
from stickslip.report.learned.parts import measures_friction
from stickslip.report.learned.scales import WORDS
from stickslip.report.learned.section_known import relative
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    symbol,
    table,
)
from stickslip.report.quantity import number
from stickslip.report.shown import parameter

MEANT = {
    "force": "{0}, recorded against implied by the recorded motion, both low-passed",
    "force_unfiltered": "The same, recorded signal as it is",
    "position": "{1}, recorded against simulated in the closed loop",
    "velocity": "Velocity, differences of the same signals",
    "closed_loop_force": "{0}, recorded against commanded in the simulated loop",
}


def write(estimation: Estimation) -> Html:
    """Return the section on judge, errors and search."""
    errors = estimation.figures.errors()
    place, push = WORDS[estimation.recording.motion]
    words = ("Friction" if measures_friction(estimation) else push.capitalize(), place.capitalize())
    rows = [
        (MEANT[name].format(*words), relative(errors[name]))
        for name in MEANT
        if math.isfinite(errors[name])
    ]
    return element(
        "section",
        element("h2", "How it was judged"),
        _judge(estimation),
        _controller(estimation),
        table(
            ("Root mean square of the difference over that of the recorded signal", ""),
            rows,
            "Relative errors of the learned drive",
        ),
        _search(estimation),
    )


def _judge(estimation: Estimation) -> Html:
    place, push = WORDS[estimation.recording.motion]
    if estimation.judge == OutputError.name:
        said = (
            "The controller ran again with the recorded commands, on a drive with each candidate’s "
            f"parameters; the differences between recorded and simulated {place} were whitened and "
            "their squares made least. Simulated recordings with the same encoder steps and as "
            "much noise then told the bias, which was taken off, and the standard errors."
        )
        if math.isfinite(estimation.model_error):
            said += (
                f" What is left is {number(estimation.model_error, 2)} times what steps and noise "
                "explain (at most 2 is good)."
            )
        return paragraph(said)
    friction = join([symbol("F", "f"), "(", symbol("v"), ") + ", symbol("F", "0")])
    if measures_friction(estimation):
        implied = join(["The recorded velocity implies the friction ", friction])
    else:
        rigid = join([symbol("m"), " ", symbol("a"), " + ", symbol("b"), " ", symbol("v"), " + "])
        implied = join([f"The recorded motion implies the {push} ", rigid, friction])
    return paragraph(
        implied,
        ", where the compensator FMU gives ",
        symbol("F", "f"),
        "; its difference from the recorded one, both through the same low-pass, was squared and "
        "made least. Standard errors allow for errors that persist from sample to sample.",
    )


def _controller(estimation: Estimation) -> Html:
    check, push = estimation.controller, WORDS[estimation.recording.motion][1]
    if check is None or not math.isfinite(check.error):
        return join([])
    samples = "sample" if check.shift == 1 else "samples"
    form = f", its {check.form}," if check.form else ""
    late = f", {check.shift} {samples} late" if check.shift else ""
    running = " It was running when the log began." if is_running(check.gains) else ""
    return paragraph(
        f"Along the recorded motion the controller given{form} commands the recorded {push}{late}, "
        f"with a relative error of {relative(check.error)}.{running}"
    )


def _search(estimation: Estimation) -> Html:
    searches = estimation.searches
    evaluations = number(float(searches["evaluations"].sum()), 7)
    title, stopped = estimation.algorithm.title, estimation.algorithm.stopped
    times = "1 search" if len(searches) == 1 else f"{len(searches)} searches"
    said = paragraph(
        f"{title[:1].upper()}{title[1:]} searched by the inverse model, {evaluations} candidates "
        f"in {times}, and least squares finished."
        + (f" Why it ended: {stopped}." if stopped else "")
    )
    if len(searches) == 1:
        return said
    rows = [
        (str(row["seed"]), number(row["cost"], 4), *(number(row[n], 4) for n in LUGRE))
        for row in searches.to_dict("records")
    ]
    head = ("Seed", "Cost", *(parameter(name) for name in LUGRE))
    return join([said, table(head, rows, "Spread over seeds, by the inverse model, in SI units")])
