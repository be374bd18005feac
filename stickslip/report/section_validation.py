"""Section 4.2 of the paper: Table 4 and Fig. 6."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.measurement import CUTOFF
from stickslip.report.markup import Html, element, join, paragraph, symbol, table
from stickslip.report.picture import Picture
from stickslip.report.quantity import number, percent
from stickslip.report.section_result import METRICS
from stickslip.report.shown import figure
from stickslip.reproduction import Reproduction
from stickslip.setup import REGION, VALIDATION
from stickslip.validation import Validation


def write(reproduction: Reproduction, pictures: Mapping[str, Picture]) -> Html:
    """Return the section on validation."""
    return describe(reproduction.validation, pictures["fig6_tracking"])


def describe(validation: Validation, tracking: Picture) -> Html:
    """Return it for any validation; ``tracking`` is Fig. 6."""
    frame = validation.table()
    rows = [
        (
            join([f"Motion {row['region']}, ", METRICS[row["metric"]]]),
            row["velocity"],
            f"{row['without']:.3f}",
            f"{row['with']:.3f}",
            percent(row["reduction"]),
            f"{row['paper_without']:.2f}",
            f"{row['paper_with']:.2f}",
            percent(row["paper_reduction"], 0),
        )
        for row in frame.to_dict("records")
    ]
    measured = frame[frame["velocity"] == "measured"]
    off = float((measured["without"] / measured["paper_without"] - 1.0).abs().max())
    begin, end = (number(1e3 * edge) for edge in REGION)
    head = (
        "", "Velocity", "Without [mm/s]", "With [mm/s]", "Reduction",
        "Paper without", "Paper with", "Paper reduction",
    )  # fmt: skip
    return element(
        "section",
        element("h2", "Validation"),
        paragraph(
            f"A trapezoid of ±{number(1e3 * VALIDATION.height)} mm/s with ramps of "
            f"{number(VALIDATION.slope)} m/s², which the learning never saw. Errors (8a), (8b) are "
            f"taken against the command from {begin} to {end} ms after the motion starts or "
            "reverses. “Measured” is the encoder’s position, differenced and low-passed at "
            f"{number(CUTOFF)} Hz without phase lag; “true” is the drive’s own velocity, which "
            "no experimenter sees, and which shows the loop’s answer to every encoder step."
        ),
        table(head, rows, "Table 4. Tracking errors, beside the paper’s", (0, 1)),
        paragraph(
            "The paper prints no unit; mm/s is the reading that fits. Without compensation the "
            f"four measured errors lie within {percent(off)} of the paper’s."
        ),
        figure(
            tracking,
            "Velocity and velocity error at motion start and reversal, without and with "
            "compensation",
            join(
                [
                    "Fig. 6. (a) The command and the measured velocity with compensation. (b), (c) "
                    "Velocity and error ",
                    symbol("v", "cmd"),
                    " − ",
                    symbol("v"),
                    " where the motion starts and reverses: measured velocity as a thick line, "
                    "true velocity as a thin one. The shaded window is judged in Table 4.",
                ]
            ),
        ),
    )
