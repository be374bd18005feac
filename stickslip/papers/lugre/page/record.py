"""Sections of record mode: validation, and the loops."""

from __future__ import annotations

from functools import partial

from stickslip.papers.lugre.page.diagrams import draw_loops
from stickslip.papers.lugre.page.validation import validation_section
from stickslip.papers.lugre.record_mode import RecordReproduction
from stickslip.presentation.markup import paragraph
from stickslip.presentation.page import Illustration, Section

FIGURES = ("fig2_loops", "fig6_tracking")


def sections(reproduction: RecordReproduction) -> list[Section]:
    """Return the sections on the loop that was designed on the learned parameters."""
    return [validation_section(reproduction.validation), _loops(reproduction)]


def _loops(reproduction: RecordReproduction) -> Section:
    options, loop = reproduction.options, reproduction.learned.designed.plain
    return Section(
        "The loops",
        paragraph(
            "The simulated drive was recorded once, for 20 s, in a soft loop without compensation "
            "that was designed on its nominal mass. The loop of the paper was then designed on the "
            "mass and viscous friction that the recording gave. With compensation, the velocity "
            "comes from a Kalman filter of encoder and motor force, and the force that accelerates "
            "the mass is fed forward; without, the loop is the plain one, because such a filter "
            "tracks worse in a loop that does not compensate friction."
        ),
        Illustration(
            "fig2_loops",
            partial(draw_loops, loop, reproduction.truth, options),
            "Block diagrams of the compensated and the nominal loop, and its step response",
            "The loops; the velocity filter, which takes the place of the velocity estimate, is "
            "not drawn.",
        ),
    )
