"""The folders that ``stickslip learn`` and ``reproduce --mode record`` leave behind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from stickslip import models
from stickslip.fmi.files import atomic_write
from stickslip.logs import Recording
from stickslip.pipeline.learned import LearnedFromRecording
from stickslip.pipeline.observed import BOTH, FEEDFORWARD, OBSERVER
from stickslip.pipeline.record_mode import RecordReproduction
from stickslip.pipeline.recorded import gains_of
from stickslip.report.learned import FILES as REPORT
from stickslip.report.learned import write_estimation_report
from stickslip.report.learned.content import compensation
from stickslip.report.learned.tracking import FIGURE as TRACKING
from stickslip.report.learned.tracking import tracking_section
from stickslip.report.page import Section, picture_files
from stickslip.report.reproduction.record import FIGURES, sections
from stickslip.results.folder import staged
from stickslip.results.learned import log_document, recording_document
from stickslip.results.reproduction_folder import command_of, write_json, write_loop, write_tables
from stickslip.rigs.contract import commissioning_loop
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.systems import nominal_parameters

TABLE = "tracking_error.csv"
"""Errors on the family of simulated drives."""
FILES = (
    "learned.json",
    "compensator.fmu",
    "observer.fmu",
    "nominal_loop.fmu",
    TABLE,
    *picture_files([TRACKING]),
    *REPORT,
)
"""What ``write_learned`` writes or removes."""
RECORD_FILES = (
    *("table2.csv", "table4.csv", "attribution.csv", "fitness.csv", "profiles.csv"),
    *("recording.csv", "recording.toml", "learned.json", "compensator.fmu", "loop.ssp"),
    *picture_files(FIGURES),
    *REPORT,
)
"""What ``write_record_results`` writes."""


def write_learned(
    learned: LearnedFromRecording, folder: Path | str, *, force: bool = False
) -> None:
    """Write learned.json, report and, if nothing speaks against it or it is forced, the FMU.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    folder = Path(folder)
    command = {"name": "learn", "log": learned.estimation.recording.source, "seed": learned.seed}
    if force:
        learned = learned.with_whole_force()
    further = []
    if learned.trial and learned.benefit:
        further.append(
            compensation(learned.benefit, learned.trial.observed, learned.trial.compared)
        )
    opening = []
    if learned.tracking and learned.trial:
        motion, share = learned.estimation.recording.motion, learned.trial.benefit.share
        refusal = "" if force else learned.refusal
        opening.append(
            tracking_section(
                learned.tracking,
                motion,
                share,
                observed=learned.observer is not None,
                compared=learned.trial.compared is not None,
                refusal=refusal,
            )
        )
    written = learned.writes(force=force)
    rotary = learned.estimation.recording.rotary
    absent = [
        "compensator.fmu",
        "observer.fmu",
        "nominal_loop.fmu",
        TABLE,
        *picture_files([TRACKING]),
    ]
    with staged(folder, command, without=absent) as staging:
        if learned.trial:
            write_tables({TABLE.removesuffix(".csv"): learned.trial.table()}, staging)
        if learned.observer and written in (OBSERVER, BOTH):
            one = learned.observer
            models.build_fmu(one.model, staging, start=one.values, called="observer", rotary=rotary)
        loop = learned.known_loop
        if loop and loop.K_x and written in (FEEDFORWARD, BOTH):
            values = nominal_parameters(loop)
            models.build_fmu("nominal_loop", staging, start=values, rotary=rotary)
        write_compensator(  # last: its page names the files beside it
            learned,
            log_document(learned),
            staging,
            further,
            opening,
            export=written in (FEEDFORWARD, BOTH),
        )


def write_compensator(
    learned: LearnedFromRecording,
    document: Mapping[str, Any],
    staging: Path,
    further: Sequence[Section],
    opening: Sequence[Section] = (),
    *,
    export: bool = True,
) -> None:
    """Write learned.json, compensator.fmu and the report on a recording.

    Parameters
    ----------
    document : content of learned.json
    further, opening : sections of the report after and before that of the parameters
    export : whether to write compensator.fmu
    """
    write_json(document, staging / "learned.json")
    if export:
        one, law = learned.feedforward, learned.estimation.law.name
        of_law = law if one.model == "compensator" else None
        rotary = learned.estimation.recording.rotary
        named: dict[str, Any] = {"law": of_law, "called": "compensator", "rotary": rotary}
        models.build_fmu(one.model, staging, start=one.values, **named)
    write_estimation_report(learned.estimation, learned.findings, staging, further, opening)


def write_record_results(reproduction: RecordReproduction, folder: Path) -> None:
    """Write the tables, the recording, report, learned.json, compensator.fmu and loop.ssp.

    ``recording.csv`` and ``recording.toml`` are what ``stickslip learn`` needs to learn the same.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    learned, loop = reproduction.learned, reproduction.learned.designed.compensated
    estimation = learned.estimation
    with staged(folder, command_of(reproduction.options, mode="record")) as staging:
        tables = {
            "table2": reproduction.table2(),
            "table4": reproduction.validation.table(),
            "attribution": reproduction.attribution,
            "fitness": estimation.algorithm.convergence(),
            "profiles": estimation.profiles,
            "recording": _table(estimation.recording),
        }
        write_tables(tables, staging)
        atomic_write(staging / "recording.toml", _description(reproduction))
        write_loop(reproduction.system, loop, staging / "loop.ssp", reproduction.options)
        write_compensator(learned, recording_document(learned), staging, sections(reproduction))


def _table(recording: Recording) -> pd.DataFrame:
    columns = {
        "time [s]": recording.t,
        "position [m]": recording.position,
        "force [N]": recording.force,
        "velocity_command [m/s]": recording.velocity_command,
    }
    return pd.DataFrame(columns)


def _description(reproduction: RecordReproduction) -> str:
    """Return what ``stickslip learn --config`` takes."""
    gains = gains_of(commissioning_loop(Datasheet()))
    lines = [
        "# Describes recording.csv for stickslip learn.",
        'motion = "linear"',
        f"encoder_step = {reproduction.learned.estimation.recording.encoder_step!r}",
        "",
        "[columns]",
        'time = { name = "time", unit = "s" }',
        'position = { name = "position", unit = "m" }',
        'force = { name = "force", unit = "N" }',
        'velocity_command = { name = "velocity_command", unit = "m/s" }',
        "",
        "[controller]",
        'kind = "PI"',
        *(f"{name} = {value!r}" for name, value in gains.items()),
    ]
    return "\n".join(lines) + "\n"
