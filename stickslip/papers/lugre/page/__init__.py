"""The pages of a reproduction: drive mode, record mode, and the learning as published."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stickslip.papers.lugre.page.as_published import study_section
from stickslip.papers.lugre.page.identification import identification_section
from stickslip.papers.lugre.page.learning import friction_section
from stickslip.papers.lugre.page.loop import design_section, use_section
from stickslip.papers.lugre.page.loop_learning import loop_learning_section
from stickslip.papers.lugre.page.result import head
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
FILES = ("report.html", *picture_files(FIGURES))
"""What ``write_report`` writes."""


def sections(reproduction: Reproduction) -> Sequence[Section]:
    """Return the sections of the page; a study that was not made has none."""
    study = reproduction.published
    found = (
        head(reproduction),
        design_section(reproduction),
        identification_section(reproduction),
        friction_section(reproduction),
        loop_learning_section(reproduction),
        validation_section(reproduction.validation, reproduction.table4()),
        steps_section(reproduction),
        study_section(study) if study else None,
        motions_section(reproduction),
        use_section(reproduction),
    )
    return [section for section in found if section is not None]


def write_report(reproduction: Reproduction, folder: Path) -> list[Path]:
    """Write the figures as PNG and SVG, and report.html; see ``write_page``."""
    return write_page(folder, TITLE, sections(reproduction))
