"""Which friction law explains the recording: the section of the page."""

from __future__ import annotations

from stickslip.identification.estimation import Estimation
from stickslip.presentation.markup import paragraph
from stickslip.presentation.page import Section
from stickslip.studies.learn import tables


def laws(estimation: Estimation) -> Section:
    """Return the section with the force error of each law that was tried."""
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
        tables.laws(estimation).html(
            "Root mean square of measured minus predicted force, and what noise and steps explain"
        ),
    )
