"""The report on one recording: figures, a table, and one page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stickslip.fmi.files import atomic_write
from stickslip.identification.estimation import Estimation
from stickslip.logs import Finding
from stickslip.presentation.page import Section, picture_files, write_page
from stickslip.studies.learn import tables
from stickslip.studies.learn.page import content

__all__ = ["FIGURES", "FILES", "sections", "write_estimation_report"]

FIGURES = ("recording", "force", "residual", "profiles", "correlations")
FILES = ("parameters.csv", "report.html", *picture_files(FIGURES))
"""What ``write_estimation_report`` writes."""


def sections(
    estimation: Estimation,
    findings: Sequence[Finding],  # of reading and checking the log
    beside: Sequence[str],  # names of the files in the page's folder
    # sections that follow that of the parameters, and that precede it
    further: Sequence[Section] = (),
    opening: Sequence[Section] = (),
    *,
    forced: bool = False,  # whether the compensator is written whatever its trial was
) -> list[Section]:
    """Return the sections of the page."""
    return [
        content.head(estimation),
        *opening,
        content.learned(estimation),
        *further,
        *([content.laws(estimation)] if estimation.held_out.predictions else []),
        content.criterion(estimation),
        content.log(estimation, findings),
        content.fit(estimation),
        content.identifiability(estimation),
        content.use(estimation, beside, forced=forced),
    ]


def write_estimation_report(
    estimation: Estimation,
    findings: Sequence[Finding],
    folder: Path,
    further: Sequence[Section] = (),
    opening: Sequence[Section] = (),
    *,
    forced: bool = False,
) -> list[Path]:
    """Write parameters.csv, each figure as PNG and SVG, and report.html.

    The page names learned.json and compensator.fmu if the folder contains them. Parameters are
    those of ``sections``, and ``write_page`` tells what is returned and raised.
    """
    table = tables.parameters(estimation).frame().to_csv(index=False, lineterminator="\n")
    written = [atomic_write(folder / "parameters.csv", table)]
    beside = [path.name for path in folder.iterdir()]
    title = f"Friction of a drive, learned from {estimation.recording.source}"
    found = sections(estimation, findings, beside, further, opening=opening, forced=forced)
    return written + write_page(folder, title, found)
