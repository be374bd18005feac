"""The folder that ``stickslip reproduce --as-published`` leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stickslip.published.whole import WholeStudy
from stickslip.report import as_published_pictures, section_as_published
from stickslip.report.picture import Picture, picture_files
from stickslip.report.sheet import sheet
from stickslip.reproduction import Options
from stickslip.result_folder import staged
from stickslip.results import command_of, write_table
from toolchain import write_whole

TITLE = "The paper’s learning as published"
TABLES = ("fitness", "table4", "learned", "readings", "readings_evaluation")
PICTURES = picture_files(section_as_published.PICTURES)
FILES = (*(f"{name}.csv" for name in TABLES), *PICTURES, "report.html")
"""What ``write_published_results`` writes."""


def write_published_results(
    study: WholeStudy, options: Options, truth: Mapping[str, float], folder: Path
) -> None:
    """Write tables, pictures and page of the study.

    Parameters
    ----------
    truth : every parameter of the drive FMU

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    seeds = len(study.published.seeds)
    with staged(folder, command_of(options, as_published=True, seeds=seeds)) as desk:
        write_study_tables(study, desk)
        drawn = study_pictures(study, truth)
        write_pictures(drawn, desk)
        page = sheet(TITLE, [section_as_published.write(study, drawn)])
        write_whole(desk / "report.html", page)


def write_study_tables(study: WholeStudy, folder: Path, prefix: str = "") -> None:
    """Write the tables of ``TABLES``, their names after a prefix."""
    published = study.published
    tables = (
        published.fitness(),
        published.table4(),
        published.learned(),
        study.readings,
        study.evaluations,
    )
    for name, table in zip(TABLES, tables, strict=True):
        write_table(table, folder / f"{prefix}{name}.csv")


def study_pictures(study: WholeStudy, truth: Mapping[str, float]) -> dict[str, Picture]:
    """Draw what ``section_as_published`` shows."""
    published = study.published
    drawn = (
        Picture.of(as_published_pictures.draw_fitness, published),
        Picture.of(as_published_pictures.draw_outcomes, published, truth),
    )
    return dict(zip(section_as_published.PICTURES, drawn, strict=True))


def write_pictures(pictures: Mapping[str, Picture], folder: Path) -> None:
    """Write pictures as PNG and SVG by their names."""
    for name, picture in pictures.items():
        write_whole(folder / f"{name}.png", picture.png)
        write_whole(folder / f"{name}.svg", picture.svg)
