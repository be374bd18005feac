"""What the training run costs without compensation and with the parameters of each stage."""

from __future__ import annotations

import math

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    symbol,
    table,
)
from stickslip.report.quantity import number, percent
from stickslip.servo.datasheet import TRAINING
from stickslip.tuning.published.study import PAPER_COST


def training_cost(reproduction: Reproduction) -> Html:
    """Return the costs as a table, with the RMS of v - v_r that each means."""
    samples = round(TRAINING.duration / reproduction.identification.loop.T_s) + 1
    without = reproduction.cost_without
    begun = "coarse start" if reproduction.options.coarse else "identified parameters"
    costs = [
        ("without compensation", without),
        (begun, reproduction.cost_of_identified),
        ("best candidate", reproduction.algorithm.best.cost),
        (reproduction.learned.result, reproduction.learned.cost),
        ("real stage (paper), as read below", PAPER_COST),
    ]
    rows = [
        (
            said,
            number(cost, 3),
            number(1e3 * math.sqrt(cost / samples), 3),
            percent(cost / without, 2) if cost != PAPER_COST else "–",
        )
        for said, cost in costs
    ]
    gap = join(["RMS of ", symbol("v"), " − ", symbol("v", "r"), " [mm/s]"])
    head = ("", "Cost (6) [m²/s²]", gap, "Of that without")
    return element(
        "div",
        table(head, rows, f"Cost of a training run of {number(samples, 6)} samples"),
        paragraph(
            f"The paper prints {number(PAPER_COST, 2)} without a unit, a sample rate or a "
            "duration. Read in m²/s² over as many samples as here, it is the velocity error in the "
            "last row. What the real stage costs without compensation is not given."
        ),
    )
