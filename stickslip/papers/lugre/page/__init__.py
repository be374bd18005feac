"""The pages of a reproduction: drive mode, record mode, and the learning as published."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from stickslip.papers.lugre.page.as_published import study_section
from stickslip.papers.lugre.page.diagrams import draw_loops
from stickslip.papers.lugre.page.identification import identification_section
from stickslip.papers.lugre.page.loop_learning import loop_learning_section
from stickslip.papers.lugre.page.result import head
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.page.validation import (
    motions_section,
    steps_section,
    validation_section,
)
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation.page import Section, picture_files, write_page

__all__ = ["FIGURES", "FILES", "TITLE", "sections", "write_report"]

TITLE = "Friction compensator of a linear motor, learned"
FIGURES = (
    "loop_tuning",
    *("fig2_loops", "fig3_scheme", "fig4_flow", "fig5_fitness", "fig6_tracking"),
    *("steps", "motions", "fig5_as_published"),
    *("identification_inertia", "identification_friction", "identification_presliding"),
)
FILES = ("report.html", *picture_files(FIGURES))  # What ``write_report`` writes


def sections(reproduction: Reproduction) -> Sequence[Section]:
    """Return the sections of the page; a study that was not made has none."""
    study, loop = reproduction.published, reproduction.identification.loop
    draw = partial(draw_loops, loop, reproduction.truth, reproduction.options)
    found = (
        head(reproduction),
        section("The loop", "loop", reproduction, {"fig2_loops": draw}),
        identification_section(reproduction),
        section("Learning the friction", "learning", reproduction),
        loop_learning_section(reproduction),
        validation_section(reproduction.validation, reproduction.table4()),
        steps_section(reproduction),
        study_section(study) if study else None,
        motions_section(reproduction),
        section("Using the results", "use", reproduction),
    )
    return [one for one in found if one is not None]


def write_report(reproduction: Reproduction, folder: Path) -> list[Path]:
    """Write the figures as PNG and SVG, and report.html; see ``write_page``."""
    return write_page(folder, TITLE, sections(reproduction))
