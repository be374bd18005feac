"""Which friction law explains the recording: the section of the page."""

from __future__ import annotations

from stickslip.catalog.parameters import unit_of
from stickslip.identification.estimation import Estimation
from stickslip.identification.selection import law_table
from stickslip.presentation.markup import paragraph, table
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import number, percentage


def laws(estimation: Estimation) -> Section:
    """Return the section with the force error of each law that was tried."""
    unit = unit_of("F_c", rotary=estimation.recording.rotary)
    rows = [
        (
            row["law"],
            number(row["held_out_error"], 3),
            percentage(row["relative"]),
            number(row["explained"], 3),
        )
        for row in law_table(estimation.held_out.predictions).to_dict("records")
    ]
    choice = ""
    if estimation.choice:
        choice = f" {estimation.choice.reason}. The parameters and the compensator are of this law."
    return Section(
        "Which friction law explains the log",
        paragraph(
            "The log is cut into blocks. A law is fitted to four fifths of them and predicts the "
            "force in the others, each fifth in turn. A drive with the fitted parameters, "
            "simulated with the log’s encoder steps and noise, gives the error of a right law."
            + choice
        ),
        table(
            (
                "Friction law",
                f"Error where not fitted [{unit}]",
                "Of the force",
                f"Explained [{unit}]",
            ),
            rows,
            "Root mean square of measured minus predicted force, and what noise and steps explain",
            (0,),
        ),
    )
