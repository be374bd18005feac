"""Whether the compensator helps, on simulated drives like the one that was learned."""

from __future__ import annotations

from stickslip.evaluation.guards import Worth
from stickslip.report.markup import (
    Html,
    element,
    paragraph,
    table,
)
from stickslip.report.quantity import number


def write(worth: Worth) -> Html:
    """Return the section with the table of tracking errors."""
    said = "Nowhere is the error larger than 1.02 times that without the compensator."
    if not worth.harmless:
        said = f"The compensator does harm: {worth.reason}."
    elif worth.share < 1.0:
        said = f"It gives {number(100.0 * worth.share, 3)} % of the learned force: {worth.reason}."
    rows = [
        (
            row.drive.replace(" x ", " × "),
            number(1e3 * row.speed, 3),
            number(1e3 * row.without, 3),
            number(1e3 * row.compensated, 3),
            number(row.ratio, 3),
        )
        for row in worth.rows
    ]
    return element(
        "section",
        element("h2", "Whether compensation helps"),
        paragraph(
            "The compensator was tried on the paper’s trapezoid at the log’s speed, a tenth and a "
            f"hundredth of it, on simulated drives. {said}"
        ),
        table(
            ("Simulated drive", "Speed", "Without", "With", "Ratio"),
            rows,
            f"RMS tracking error, all in {worth.unit}",
            (0,),
        ),
    )
