"""The folders that ``stickslip validate --log`` leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from stickslip.evaluation.log_prediction import LogPrediction
from stickslip.report.page import picture_files, write_page
from stickslip.report.validated import FIGURES, log_sections
from stickslip.results.folder import staged
from stickslip.results.learned import LearnedFile
from stickslip.results.reproduction_folder import write_tables

LOG_FILES = ("prediction.csv", "changes.csv", "spans.csv", "report.html", *picture_files(FIGURES))
"""What ``write_log_validation`` writes."""


def write_log_validation(
    found: LogPrediction,
    learned: LearnedFile,
    controller: str,
    folder: Path,
    command: Mapping[str, object],
) -> None:
    """Write the errors of a log's signals, what has changed, errors over the log, and the page.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    tables = {
        "prediction": pd.DataFrame(
            {"signal": name, **vars(one), "ratio": one.ratio} for name, one in found.signals.items()
        ),
        "changes": pd.DataFrame(
            {"parameter": name, **vars(one)} for name, one in found.changes.items()
        ),
        "spans": found.spans,
    }
    sections = log_sections(found, learned.drive, learned.path.name, controller)
    with staged(folder, command) as staging:
        write_tables(tables, staging)
        title = f"{learned.path.name} against the log {found.recording.source}"
        write_page(staging, title, sections)
