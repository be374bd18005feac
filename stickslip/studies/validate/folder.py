"""The folders that ``stickslip validate --log`` leaves behind."""

from collections.abc import Mapping
from pathlib import Path

from stickslip.learned.file import LearnedFile
from stickslip.presentation.page import picture_files, write_page
from stickslip.storage import staged
from stickslip.storage.writing import write_tables
from stickslip.studies.validate import tables
from stickslip.studies.validate.compared_logs import LogComparison
from stickslip.studies.validate.log_prediction import LogPrediction
from stickslip.studies.validate.page import comparison, log

LOG_FILES = (
    "prediction.csv",
    "changes.csv",
    "spans.csv",
    "report.html",
    *picture_files(log.FIGURES),
)
"""What ``write_log_validation`` writes."""
COMPARISON_FILES = ("tracking.csv", "report.html", *picture_files(comparison.FIGURES))
"""What ``write_comparison`` writes."""


def write_log_validation(
    found: LogPrediction,
    learned: LearnedFile,
    controller: str,
    folder: Path,
    command: Mapping[str, object],
) -> None:
    """Write the errors of a log's signals, what has changed, errors over the log, and the page.

    Raises OSError when a file cannot be written.
    """
    frames = {
        "prediction": tables.signals(found).frame(),
        "changes": tables.changes(found, learned.drive).frame(),
        "spans": tables.spans(found).frame(),
    }
    sections = log.log_sections(found, learned.drive, learned.path.name, controller)
    with staged(folder, command) as staging:
        write_tables(frames, staging)
        title = f"{learned.path.name} against the log {found.recording.source}"
        write_page(staging, title, sections)


def write_comparison(
    found: LogComparison, logs: tuple[str, str], learned: LearnedFile, controller: str, folder: Path
) -> None:
    """Write the tracking errors of two logs, without and with the compensator, and the page.

    Raises OSError when a file cannot be written.
    """
    sections = comparison.comparison_sections(found, logs, learned.path.name, controller)
    command = {"name": "validate", "without": logs[0], "log": logs[1]}
    with staged(folder, command) as staging:
        write_tables({"tracking": tables.tracking(found).frame()}, staging)
        write_page(staging, f"{logs[1]} against {logs[0]}: what the compensator brought", sections)
