"""The page of a reproduction: its sections in their order."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.picture import Picture
from stickslip.report.reproduction import (
    section_as_published,
    section_design,
    section_identification,
    section_learning,
    section_motions,
    section_result,
    section_steps,
    section_use,
    section_validation,
)
from stickslip.report.sheet import sheet

TITLE = "Friction compensator of a linear motor, learned"


def page(reproduction: Reproduction, pictures: Mapping[str, Picture]) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    reproduction : every number comes from here
    pictures : by the names of ``FIGURES``
    """
    sections = (
        section_result,
        section_design,
        section_identification,
        section_learning,
        section_validation,
        section_steps,
        section_as_published,
        section_motions,
        section_use,
    )
    return sheet(TITLE, (section.write(reproduction, pictures) for section in sections))
