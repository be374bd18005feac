"""The folder that ``stickslip reproduce --mode record`` leaves behind."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from stickslip.fmi.files import atomic_write
from stickslip.logs import Recording
from stickslip.pipeline.record_mode import RecordReproduction, commissioning_loop, gains_of
from stickslip.report.learned import FILES as REPORT
from stickslip.report.page import picture_files
from stickslip.report.reproduction.record import FIGURES, sections
from stickslip.results.folder import staged
from stickslip.results.learned import recording_document
from stickslip.results.learned_folder import write_compensator
from stickslip.results.reproduction_folder import command_of, write_loop, write_table
from stickslip.servo.datasheet import Datasheet

FILES = (
    *("table2.csv", "table4.csv", "attribution.csv", "fitness.csv", "profiles.csv"),
    *("recording.csv", "recording.toml", "learned.json", "compensator.fmu", "loop.ssp"),
    *picture_files(FIGURES),
    *REPORT,
)
"""What ``write_record_results`` writes."""


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
        write_table(reproduction.table2(), staging / "table2.csv")
        write_table(reproduction.validation.table(), staging / "table4.csv")
        write_table(reproduction.attribution, staging / "attribution.csv")
        write_table(estimation.algorithm.convergence(), staging / "fitness.csv")
        write_table(estimation.profiles, staging / "profiles.csv")
        _write_recording(estimation.recording, staging / "recording.csv")
        atomic_write(staging / "recording.toml", _description(reproduction))
        write_loop(reproduction.system, loop, staging / "loop.ssp")
        write_compensator(learned, recording_document(learned), staging, sections(reproduction))


def _write_recording(recording: Recording, path: Path) -> None:
    table = {
        "time [s]": recording.t,
        "position [m]": recording.position,
        "force [N]": recording.force,
        "velocity_command [m/s]": recording.velocity_command,
    }
    write_table(pd.DataFrame(table), path)


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
