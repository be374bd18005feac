"""The report on what one recording taught: pictures, a table, and one page.

    learned_report.write_estimation_report(estimation, findings, Path("results/log"))

A file a picture, a file a section, as in ``stickslip.report.reproduction``, whose style it shares;
the same estimation gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from stickslip.fmi.files import atomic_write
from stickslip.identification.estimation import Estimation
from stickslip.logs import Finding
from stickslip.report.learned import (
    force_picture,
    profiles_picture,
    recording_picture,
    residual_picture,
    section_fit,
    section_judge,
    section_known,
    section_log,
    section_use,
)
from stickslip.report.learned.parameter_table import parameter_table
from stickslip.report.markup import Html
from stickslip.report.picture import Picture, picture_files
from stickslip.report.sheet import sheet

__all__ = ["FILES", "PICTURES", "parameter_table", "write_estimation_report"]

PICTURES: dict[str, Callable[[Estimation], Figure]] = {
    "recording": recording_picture.draw,
    "force": force_picture.draw,
    "residual": residual_picture.draw,
    "profiles": profiles_picture.draw,
}
"""The pictures by the name of their files."""
FILES = ("parameters.csv", "report.html", *picture_files(PICTURES))
"""What ``write_estimation_report`` writes."""


def write_estimation_report(
    estimation: Estimation,
    findings: Sequence[Finding],
    folder: Path,
    further: Sequence[Html] = (),
) -> list[Path]:
    """Write parameters.csv, every picture as PNG and SVG, and report.html, which holds them.

    The page names learned.json and compensator.fmu where they are in the folder already.

    Parameters
    ----------
    estimation : what was learned
    findings : of reading and checking the log
    further : sections that follow the first
    folder : is made if it is absent; files of the same names are replaced, each as a whole

    Returns
    -------
    the files written, the page last

    Raises
    ------
    OSError
        When the folder cannot be written.
    """
    table = parameter_table(estimation).to_csv(index=False, lineterminator="\n")
    written = [atomic_write(folder / "parameters.csv", table)]
    pictures = {name: Picture.of(draw, estimation) for name, draw in PICTURES.items()}
    for name, picture in pictures.items():
        written.append(atomic_write(folder / f"{name}.png", picture.png))
        written.append(atomic_write(folder / f"{name}.svg", picture.svg))
    beside = [path.name for path in folder.iterdir()]
    sections = (
        section_known.write(estimation),
        *further,
        section_judge.write(estimation),
        section_log.write(estimation, findings, pictures),
        section_fit.write(estimation, pictures),
        section_use.write(estimation, beside),
    )
    title = f"Friction of a drive, learned from {estimation.recording.source}"
    written.append(atomic_write(folder / "report.html", sheet(title, sections)))
    return written
