"""Section 4.2 of the paper: Table 4 and Fig. 6."""

from __future__ import annotations

from functools import partial

import pandas as pd

from stickslip.evaluation.validation import Validation
from stickslip.report.markup import METRICS, Html, join, paragraph, symbol, table
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import number, percent
from stickslip.report.reproduction.curves import draw_tracking
from stickslip.servo.datasheet import REGION, VALIDATION
from stickslip.servo.measurement import CUTOFF


def validation_section(validation: Validation) -> Section:
    """Return the section on validation."""
    frame = validation.table()
    begin, end = (number(1e3 * edge) for edge in REGION)
    return Section(
        "Validation",
        paragraph(
            "The simulated drive follows a trapezoid of "
            f"±{number(1e3 * VALIDATION.height)} mm/s with ramps of "
            f"{number(VALIDATION.slope)} m/s², which the learning never saw. Errors (8a), (8b) are "
            f"taken against the command from {begin} to {end} ms after the motion starts or "
            "reverses. “Measured” is the encoder’s position, differenced and low-passed at "
            f"{number(CUTOFF)} Hz without phase lag; “true” is the drive’s own velocity, which "
            "no experimenter sees, and which shows the loop’s answer to every encoder step."
        ),
        table(
            ("", "", "Without [mm/s]", "With [mm/s]", "Reduction"),
            _rows(frame),
            "Table 4. Tracking errors of the simulated drive, calibrated to “Without”, measured, "
            "of the real stage (paper)",
            (0, 1),
        ),
        paragraph(
            "The paper prints no unit; mm/s is the reading that fits. It gives neither gains nor "
            "ramps, windows or filters either. They were searched so that the errors of the "
            "simulated drive with the paper’s parameters, without compensation and as measured, "
            "come near those of the real stage. That these agree is therefore no evidence."
        ),
        Illustration(
            "fig6_tracking",
            partial(draw_tracking, validation),
            "Velocity and velocity error of the simulated drive at motion start and reversal, "
            "without and with compensation",
            join(
                [
                    "Fig. 6. The simulated drive. (a) The command and the measured velocity with "
                    "compensation. (b), (c) Velocity and error ",
                    symbol("v", "cmd"),
                    " − ",
                    symbol("v"),
                    " where the motion starts and reverses: measured velocity as a thick line, "
                    "true velocity as a thin one. Table 4 evaluates the shaded window.",
                ]
            ),
        ),
    )


def _rows(frame: pd.DataFrame) -> list[tuple[Html, str, str, str, str]]:
    """Return each error of the simulated drive, measured and true, and then the real stage's."""
    rows = []
    for (region, metric), errors in frame.groupby(["region", "metric"], sort=False):
        name = join([f"Motion {region}, ", METRICS[str(metric)]])
        for row in errors.to_dict("records"):
            label = f"simulated drive, {row['velocity']}"
            numbers = f"{row['without']:.3f}", f"{row['with']:.3f}", percent(row["reduction"])
            rows.append((name, label, *numbers))
        without, compensated, less = errors[
            ["paper_without", "paper_with", "paper_reduction"]
        ].iloc[0]
        numbers = f"{without:.2f}", f"{compensated:.2f}", percent(less, 0)
        rows.append((name, "real stage (paper)", *numbers))
    return rows
