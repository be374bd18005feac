"""The paper from one recording: record, learn, design, validate, and the folder that is left.

The drive is run once, for 20 s, in a commissioning loop that needs to know its mass to within a
factor of three. All that is learned comes from that recording; Table 4 is then measured with the
velocity filter and feedforward of inertia that a known mass allows.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

from stickslip.fmi.files import atomic_write
from stickslip.identification.estimation import Estimation, LearnSettings, Search
from stickslip.learned.deploying import build_parts
from stickslip.learned.file import LearnedFile
from stickslip.logs import Recording, check_recording
from stickslip.output import Progress
from stickslip.papers.lugre.folder import command_of, write_loop
from stickslip.papers.lugre.page import section, validation_section
from stickslip.papers.lugre.reproduction import BaseResult, Options, build_rig, validated
from stickslip.papers.lugre.tables import table2_of_recording
from stickslip.presentation.page import picture_files
from stickslip.rigs.contract import commissioning_loop
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_loop import design_velocity_loop
from stickslip.storage import staged
from stickslip.storage.writing import write_json, write_tables
from stickslip.studies.learn.document import recording_document
from stickslip.studies.learn.learned import LearnedFromRecording, learn_recording
from stickslip.studies.learn.page import FILES as REPORT
from stickslip.studies.learn.page import write_estimation_report
from stickslip.studies.learn.recorded import gains_of, record_drive
from stickslip.trial.compensator_trial import Loops


@dataclass(frozen=True)
class RecordReproduction(BaseResult):
    """All that was computed from one recording."""

    learned: LearnedFromRecording

    def table2(self) -> pd.DataFrame:
        """Return Table 2 with what was learned."""
        return table2_of_recording(self.learned.estimation, self.truth)


def loops_of_drive(sheet: Datasheet, estimation: Estimation) -> Loops:
    """Return the paper's loop for a learned axis, and that with velocity filter and inertia."""
    known = estimation.known
    plain = design_velocity_loop(sheet.axis(known["m"].value, max(known["b"].value, 0.0)), LOOP)
    F_c = estimation.compensator["F_c"]
    return Loops(plain, with_inertia(with_velocity_filter(plain, sheet, F_c)))


def learn_from_recording(
    rig: FmuRig, seed: int, search: Search, progress: Progress
) -> LearnedFromRecording:
    """Record a drive once, learn from the recording and design the loops, or raise."""
    progress.stage("recording the drive")
    recording = record_drive(rig)
    return learn_recording(
        recording,
        gains_of(rig.loop),
        partial(loops_of_drive, rig.datasheet),
        check_recording(recording),
        settings=LearnSettings(law=rig.law.name, seed=seed, search=search),
        progress=progress,
    )


def reproduce_from_recording(
    options: Options, fmus: Path, progress: Progress, workers: int = 1
) -> RecordReproduction:
    """Run the whole; FMUs are built into the folder ``fmus``. Raises as ``reproduce``."""
    rig = build_rig(options, fmus, progress)
    search = Search(options.preset, workers=workers)
    learned = learn_from_recording(rig, options.seed, search, progress)
    return RecordReproduction(**vars(validated(options, rig, learned, progress)))


LOG_FILES = ("recording.csv", "recording.toml")
"""What ``write_log`` writes: what ``stickslip learn`` takes."""
RECORD_FILES = (
    *("table2.csv", "table4.csv", "fitness.csv", "profiles.csv", *LOG_FILES),
    *("learned.json", "compensator.fmu", "loop.ssp"),
    *picture_files(["fig6_tracking"]),
    *REPORT,
)
"""What ``write_record_results`` writes."""


def write_log(recording: Recording, options: Options, folder: Path) -> None:
    """Write one recording of the simulated drive, and nothing else."""
    with staged(folder, command_of(options, mode="log")) as staging:
        _write_log(recording, staging)


def _write_log(recording: Recording, folder: Path) -> None:
    columns = {
        "time [s]": recording.t,
        "position [m]": recording.position,
        "force [N]": recording.force,
        "velocity_command [m/s]": recording.velocity_command,
    }
    write_tables({"recording": pd.DataFrame(columns)}, folder)
    atomic_write(folder / "recording.toml", _description(recording))


def write_record_results(reproduction: RecordReproduction, folder: Path) -> None:
    """Write the results as a whole, with what ``stickslip learn`` needs to learn the same."""
    learned, loop = reproduction.learned, reproduction.learned.designed.compensated
    estimation = learned.estimation
    with staged(folder, command_of(reproduction.options, mode="record")) as staging:
        table4 = reproduction.validation.table()
        tables = {
            "table2": reproduction.table2(),
            "table4": table4,
            "fitness": estimation.searched.convergence(),
            "profiles": estimation.profiles,
        }
        write_tables(tables, staging)
        _write_log(estimation.recording, staging)
        write_loop(reproduction.system, loop, staging / "loop.ssp", reproduction.options)
        write_json(recording_document(learned), staging / "learned.json")
        build_parts(LearnedFile(staging / "learned.json"), staging)
        sections = [
            validation_section(reproduction.validation, table4),
            section("The loop", "record", reproduction),
        ]
        write_estimation_report(estimation, learned.findings, staging, sections)


def _description(recording: Recording) -> str:
    """Return what ``stickslip learn --config`` takes."""
    gains = gains_of(commissioning_loop(Datasheet()))
    lines = [
        "# Describes recording.csv for stickslip learn.",
        'motion = "linear"',
        f"encoder_step = {recording.encoder_step!r}",
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
