"""The folder that ``stickslip reproduce --as-published`` leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stickslip.fmi.files import atomic_write
from stickslip.pipeline.reproduction import Options
from stickslip.report.picture import picture_files
from stickslip.report.reproduction import section_as_published
from stickslip.report.sheet import sheet
from stickslip.results.folder import staged
from stickslip.results.reproduction_folder import command_of, write_table
from stickslip.tuning.published.whole import TABLES, WholeStudy

TITLE = "The paper’s learning as published"
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
    with staged(folder, command_of(options, as_published=True, seeds=seeds)) as staging:
        for name, table in study.tables().items():
            write_table(table, staging / f"{name}.csv")
        drawn = section_as_published.draw(study.published, truth)
        for name, picture in drawn.items():
            atomic_write(staging / f"{name}.png", picture.png)
            atomic_write(staging / f"{name}.svg", picture.svg)
        page = sheet(TITLE, [section_as_published.describe(study, drawn)])
        atomic_write(staging / "report.html", page)
