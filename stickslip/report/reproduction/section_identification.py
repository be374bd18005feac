"""Section 2.4 of the paper: three experiments and what they found."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    table,
)
from stickslip.report.picture import Picture
from stickslip.report.quantity import (
    MEANINGS,
    number,
    percent,
)
from stickslip.report.reproduction.known_beforehand import known_beforehand
from stickslip.report.shown import (
    figure,
    parameter,
    parameter_estimate,
    parameter_unit,
    parameter_value,
)


def write(reproduction: Reproduction, pictures: Mapping[str, Picture]) -> Html:
    """Return the section on identification."""
    identification = reproduction.identification
    friction = identification.friction
    forward, back = (number(force, 3) for force in friction.breakaway)
    rows = [
        (
            parameter(name),
            MEANINGS[name],
            parameter_estimate(name, estimate),
            percent(estimate.standard_error / abs(estimate.value), 2),
            parameter_value(name, reproduction.truth[name]),
            parameter_unit(name),
        )
        for name, estimate in identification.estimates.items()
    ]
    figures = (
        figure(
            pictures["identification_inertia"],
            "Motor force over acceleration, with the fitted line",
            join(
                [
                    "Stage 1. A strong, slow sine of force; the slope of force over acceleration "
                    "is ",
                    parameter("m"),
                    ".",
                ]
            ),
        ),
        figure(
            pictures["identification_friction"],
            "Friction force over velocity in both directions, with the fitted Stribeck curve",
            "Stage 2. Mean force at constant velocities, forth and back over the same positions, "
            "with standard errors (mostly smaller than the marks), and the break-away force: "
            f"{forward} N forward and {back} N back at a ramp of {number(friction.ramp_rate, 2)} "
            "N/s. A faster ramp breaks away later. Encoder steps make the velocity fluctuate by "
            f"{number(1e3 * friction.fluctuation, 2)} mm/s, which lowers the mean force of the "
            "slowest points; the curve is without it.",
        ),
        figure(
            pictures["identification_presliding"],
            "Force steps, encoder position and fitted position over time",
            "Stage 3. Force steps below break-away bend the bristles; their stiffness and damping "
            "are fitted to the position that the encoder shows.",
        ),
    )
    return element(
        "section",
        element("h2", "Identification"),
        paragraph(
            "Three experiments on the simulated drive find its parameters coarsely. Learning "
            "begins at these values and searches from 0.1 to 100 times each."
        ),
        element("div", join(figures, "\n"), class_="row"),
        table(
            ("", "", "Identified", "Standard error", "Simulated drive", "Unit"),
            rows,
            "Identified parameters (value ± standard error)",
            (0, 1, 5),
        ),
        known_beforehand(reproduction),
    )
