"""The friction: least squares on runs of the drive, and Table 2 with what was learned."""

from __future__ import annotations

import math

from stickslip.catalog.parameters import PAPER
from stickslip.evaluation.motions import TRAINING
from stickslip.papers.lugre.published import PAPER_COST
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation.markup import Html, element, join, paragraph, table
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import (
    number,
    parameter_estimate,
    parameter_unit,
    parameter_value,
    percent,
    symbol,
)


def friction_section(reproduction: Reproduction) -> Section:
    """Return the section on the friction that is learned."""
    return Section(
        "Learning the friction",
        _course(reproduction),
        _training_cost(reproduction),
        _table2(reproduction),
        _remarks(reproduction),
    )


def _course(reproduction: Reproduction) -> Html:
    learned, factors = reproduction.refinement, reproduction.options.coarse
    text = "Learning began with the identified parameters"
    if factors:
        times = ", ".join(f"{name} × {number(factor, 6)}" for name, factor in factors.items())
        text = f"Learning began away from the identified parameters: {times}"
    text += (
        ". Least squares combined repeated runs of the training command, of its mirror image and "
        f"of slow motions, {learned.runs} in all, with these values as a prior; the paper’s "
        "genetic algorithm takes some twenty times as many for no better result. "
    )
    kept = "The fit was worse on the drive, so the start values are kept"
    if learned.accepted:
        kept = "The fit is kept"
    return paragraph(f"{text}{kept}: {learned.remark}.")


def _table2(reproduction: Reproduction) -> Html:
    identified, learned = reproduction.identification.estimates, reproduction.refinement.estimates
    rows = []
    for name, found in identified.items():
        estimate, truth = learned.get(name), reproduction.truth[name]
        rows.append(
            (
                symbol(name),
                parameter_value(name, PAPER.get(name, math.nan)),
                parameter_value(name, truth),
                parameter_estimate(name, found),
                parameter_estimate(name, estimate) if estimate else "–",
                *(
                    percent(e.value / truth - 1.0, 2) if e and truth else "–"
                    for e in (found, estimate)
                ),
                parameter_unit(name),
            )
        )
    head = (
        "", "Real stage (paper)", "Simulated drive", "Identified", "Learned",
        "Identified, off by", "Learned, off by", "Unit",
    )  # fmt: skip
    return table(head, rows, "Table 2. Parameters (value ± standard error)", (0, 7))


def _remarks(reproduction: Reproduction) -> Html:
    remarks = reproduction.table2().set_index("parameter")["remark"]
    items = [
        element("li", f"{symbol(name)}: {remarks[name]}".replace("+-", "±").replace("'", "’"))
        for name in reproduction.refinement.estimates
    ]
    return element("ul", join(items, "\n"))


def _training_cost(reproduction: Reproduction) -> Html:
    """Return the costs as a table, with the RMS of v - v_r that each means."""
    samples = round(TRAINING.duration / reproduction.identification.loop.T_s) + 1
    without = reproduction.cost_without
    costs = [
        ("without compensation", without),
        (reproduction.refinement.result, reproduction.refinement.cost),
        ("real stage (paper), as read below", PAPER_COST),
    ]
    rows = [
        (
            label,
            number(cost, 3),
            number(1e3 * math.sqrt(cost / samples), 3),
            percent(cost / without, 2) if cost != PAPER_COST else "–",
        )
        for label, cost in costs
    ]
    head = ("", "Cost (6) [m²/s²]", "RMS of $v$ − $v_r$ [mm/s]", "Of that without")
    return element(
        "div",
        table(head, rows, f"Cost of a training run of {number(samples, 6)} samples"),
        paragraph(
            f"The paper prints {number(PAPER_COST, 2)} without a unit, a sample rate or a "
            "duration. Read in m²/s² over as many samples as here, it is the velocity error in the "
            "last row. What the real stage costs without compensation is not given."
        ),
    )
