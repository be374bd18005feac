"""The folder that ``stickslip learn`` leaves behind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stickslip import models
from stickslip.pipeline.learned import LearnedFromRecording
from stickslip.report.learned import FILES as REPORT
from stickslip.report.learned import write_estimation_report
from stickslip.report.learned.content import compensation
from stickslip.report.page import Section
from stickslip.results.folder import staged
from stickslip.results.learned import log_document
from stickslip.results.reproduction_folder import write_json

FILES = ("learned.json", "compensator.fmu", *REPORT)
"""What ``write_learned`` writes or removes."""


def write_learned(learned: LearnedFromRecording, folder: Path, *, force: bool = False) -> None:
    """Write learned.json, report and, if nothing speaks against it or it is forced, the FMU.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    command = {"name": "learn", "log": learned.estimation.recording.source, "seed": learned.seed}
    if force:
        learned = learned.with_whole_force()
    further = [compensation(learned.trial.benefit)] if learned.trial else []
    with staged(folder, command, without=["compensator.fmu"]) as staging:
        write_compensator(
            learned, log_document(learned), staging, further, export=force or not learned.refusal
        )


def write_compensator(
    learned: LearnedFromRecording,
    document: Mapping[str, Any],
    staging: Path,
    further: Sequence[Section],
    *,
    export: bool = True,
) -> None:
    """Write learned.json, compensator.fmu and the report on a recording.

    Parameters
    ----------
    document : content of learned.json
    further : sections of the report
    export : whether to write compensator.fmu
    """
    write_json(document, staging / "learned.json")
    if export:
        law = learned.estimation.law.name
        models.build_fmu("compensator", staging, start=learned.compensator, law=law)
    write_estimation_report(learned.estimation, learned.findings, staging, further)
