"""Sections of record mode: validation, and the loops."""

from __future__ import annotations

from functools import partial

from stickslip.papers.lugre.page.diagrams import draw_loops
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.page.validation import validation_section
from stickslip.papers.lugre.record_mode import RecordReproduction
from stickslip.presentation.page import Section

FIGURES = ("fig2_loops", "fig6_tracking")


def sections(reproduction: RecordReproduction) -> list[Section]:
    """Return the sections on the loop that was designed on the learned parameters."""
    options, loop = reproduction.options, reproduction.learned.designed.plain
    draw = partial(draw_loops, loop, reproduction.truth, options)
    loops = section("The loops", "record", reproduction, {"fig2_loops": draw})
    return [validation_section(reproduction.validation), loops]
