"""The learned drive against the recording, and how sharply the recording decides."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.identification.estimation import Estimation
from stickslip.report.learned.parts import measures_friction
from stickslip.report.learned.profiles_picture import unresolved
from stickslip.report.learned.scales import WORDS
from stickslip.report.learned.section_known import relative
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
)
from stickslip.report.picture import Picture
from stickslip.report.shown import figure, parameter


def write(estimation: Estimation, pictures: Mapping[str, Picture]) -> Html:
    """Return two sections: the fit, and what is known."""
    fit = element(
        "section",
        element("h2", "The learned drive against the recording"),
        _force(estimation, pictures["force"]),
        _residual(estimation, pictures["residual"]),
    )
    known = element(
        "section",
        element("h2", "How well it is known"),
        paragraph(
            "A profile holds one parameter at a value and lets all others follow; its deviance is "
            "twice the loss of log likelihood. Where it stays below 3.84 lies a 95 % interval. A "
            "flat profile says that the recording does not show the parameter."
        ),
        figure(
            pictures["profiles"],
            "Profile likelihoods of the five parameters of LuGre’s model",
            _profiles(estimation),
        ),
    )
    return join([fit, known], "\n")


def _force(estimation: Estimation, picture: Picture) -> Html:
    error = relative(estimation.figures.force)
    if measures_friction(estimation):
        return figure(
            picture,
            "Friction over position in loops, and over time, recorded and learned",
            f"(a) Friction over position, recorded and learned, relative error {error}. "
            "The learned loop begins with bristles at rest. (b), (c) The same over time, and its "
            "difference.",
        )
    push = WORDS[estimation.recording.motion][1]
    return figure(
        picture,
        "Recorded and implied force over time, its difference, and friction over velocity",
        f"(a), (b) The recorded {push} and the one that the recorded motion implies with the "
        f"learned parameters, relative error {error}. (c), (d) Recorded {push} without inertia and "
        "constant force, beside the learned Stribeck curve with viscous friction; soon after a "
        "reversal bristles still bend, and friction is not on the curve.",
    )


def _residual(estimation: Estimation, picture: Picture) -> Html:
    place, push = WORDS[estimation.recording.motion]
    if estimation.figures.simulated is None:
        left = "friction" if measures_friction(estimation) else push
        what = f"Recorded less implied {left}"
    else:
        error = relative(estimation.figures.position)
        what, left = (
            f"Recorded less simulated {place}: the controller and the learned drive ran with the "
            f"recorded commands, relative error {error}",
            place,
        )
    return figure(
        picture,
        f"What is left of the {left}, over time, {place} and velocity",
        f"{what}. A pattern over {place} tells of ripple or friction that depends on the {place}, "
        "one over velocity of friction that the model has not.",
    )


def _profiles(estimation: Estimation) -> Html:
    names = unresolved(estimation)
    said = "Profile likelihoods, at up to three standard errors on either side."
    if not names:
        return join([said])
    listed = join([parameter(name) for name in names], ", ")
    return join(
        [
            f"{said} Not drawn for ",
            listed,
            ": a bound, or that the others could not follow, leaves no curve.",
        ]
    )
