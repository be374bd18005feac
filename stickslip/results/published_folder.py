"""The folder that ``stickslip reproduce --as-published`` leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stickslip.pipeline.reproduction import Options
from stickslip.report.page import picture_files, write_page
from stickslip.report.reproduction.as_published import FIGURES, study_section
from stickslip.results.folder import staged
from stickslip.results.reproduction_folder import command_of, write_table
from stickslip.tuning.published.readings import TABLES, WholeStudy

TITLE = "The paper’s learning as published"
FILES = (*(f"{name}.csv" for name in TABLES), *picture_files(FIGURES), "report.html")
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
        write_page(staging, TITLE, [study_section(study, truth)])
