"""The compensator's FMU: what it says of itself, and whether FMPy computes the same force."""

from __future__ import annotations

from stickslip.evaluation.fmpy_check import Comparison, SecondOpinion
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    table,
)
from stickslip.report.quantity import number, unit


def fmu(opinion: SecondOpinion) -> Html:
    """Return its description as FMPy reads it, and the comparison of the runs."""
    said = [
        (key, element("span", value, class_="prose")) for key, value in opinion.description.items()
    ]
    rows = [
        (
            element("code", variable.name),
            variable.causality,
            variable.start or "–",
            unit(variable.unit),
            element("span", variable.description, class_="prose"),
        )
        for variable in opinion.variables
    ]
    head = ("", "Causality", "Start", "Unit", "")
    compared = [
        (
            name,
            number(comparison.samples, 7),
            number(comparison.different, 7),
            number(comparison.largest, 3),
        )
        for name, comparison in opinion.comparisons.items()
    ]
    return join(
        [
            element("h3", "The compensator’s FMU, read and run by FMPy"),
            table(("", f"As {opinion.tool} reads it"), said, "compensator.fmu", (0, 1)),
            table(
                head,
                rows,
                "Its variables",
                {0, 1, 3, 4},
            ),
            paragraph(
                f"{opinion.tool} also ran compensator.fmu alone (",
                element("code", "simulate_fmu"),
                ") over the velocities that the compensator had in two runs of the whole loop. "
                f"{_verdict(list(opinion.comparisons.values()))}",
            ),
            table(
                ("Run", "Samples of F_mean", "Different", "Largest difference [N]"),
                compared,
                "Force of the compensator, this run’s kernel against FMPy",
            ),
        ],
        "\n",
    )


def _verdict(comparisons: list[Comparison]) -> str:
    different = sum(comparison.different for comparison in comparisons)
    samples = number(sum(comparison.samples for comparison in comparisons), 7)
    if not different:
        return f"All {samples} samples of its force are the same bit for bit."
    return f"{number(different, 7)} of {samples} samples of its force differ."
