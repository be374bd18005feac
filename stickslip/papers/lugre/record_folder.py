"""The folder that ``reproduce --mode record`` leaves behind."""

from functools import partial
from pathlib import Path

import pandas as pd

from stickslip.fmi.files import atomic_write
from stickslip.logs import Recording
from stickslip.papers.lugre.folder import command_of, write_loop
from stickslip.papers.lugre.page.diagrams import draw_loops
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.page.validation import validation_section
from stickslip.papers.lugre.record_mode import RecordReproduction
from stickslip.presentation.page import Section, picture_files
from stickslip.rigs.contract import commissioning_loop
from stickslip.servo.axis import Datasheet
from stickslip.storage import staged
from stickslip.storage.writing import write_json, write_tables
from stickslip.studies.learn.document import recording_document
from stickslip.studies.learn.folder import build_part, deployed_feedforward
from stickslip.studies.learn.page import FILES as REPORT
from stickslip.studies.learn.page import write_estimation_report
from stickslip.studies.learn.recorded import gains_of

RECORD_FILES = (
    *("table2.csv", "table4.csv", "fitness.csv", "profiles.csv"),
    *("recording.csv", "recording.toml", "learned.json", "compensator.fmu", "loop.ssp"),
    *picture_files(["fig2_loops", "fig6_tracking"]),
    *REPORT,
)
"""What ``write_record_results`` writes."""


def write_record_results(reproduction: RecordReproduction, folder: Path) -> None:
    """Write the tables, the recording, report, learned.json, compensator.fmu and loop.ssp.

    ``recording.csv`` and ``recording.toml`` are what ``stickslip learn`` needs to learn the same.
    Raises OSError when a file cannot be written.
    """
    learned, loop = reproduction.learned, reproduction.learned.designed.compensated
    estimation = learned.estimation
    with staged(folder, command_of(reproduction.options, mode="record")) as staging:
        tables = {
            "table2": reproduction.table2(),
            "table4": reproduction.validation.table(),
            "fitness": estimation.searches.algorithm.convergence(),
            "profiles": estimation.fitted.profiles,
            "recording": _table(estimation.recording),
        }
        write_tables(tables, staging)
        atomic_write(staging / "recording.toml", _description(reproduction))
        write_loop(reproduction.system, loop, staging / "loop.ssp", reproduction.options)
        write_json(recording_document(learned), staging / "learned.json")
        build_part(learned, deployed_feedforward(learned), "compensator", staging)
        write_estimation_report(estimation, learned.findings, staging, _sections(reproduction))


def _sections(reproduction: RecordReproduction) -> list[Section]:
    """Return the sections on the loop that was designed on the learned parameters."""
    loop = reproduction.learned.designed.plain
    draw = partial(draw_loops, loop, reproduction.truth, reproduction.options)
    loops = section("The loops", "record", reproduction, {"fig2_loops": draw})
    return [validation_section(reproduction.validation), loops]


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
