"""What ``stickslip validate LEARNED --log`` does: another log against a learned drive."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stickslip import cosim, logs
from stickslip.errors import UsageError
from stickslip.evaluation.tracking import FEEDFORWARD, NONE, LearnedDrive, simulate
from stickslip.identification.criteria.controller_check import check_controller, in_time
from stickslip.identification.criteria.motion import recording_scale
from stickslip.identification.estimation import candidate_fmus
from stickslip.learned.file import LearnedFile
from stickslip.logs.description import Controller
from stickslip.logs.reading import with_velocity_command
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.studies.validate.compared_logs import LogComparison, common, compare, compared
from stickslip.studies.validate.log_prediction import LogPrediction, predict_log


@dataclass(frozen=True)
class LogInLoop:
    """A log that was read, and the controller with which it was recorded."""

    reading: logs.Reading
    gains: Mapping[str, float] | None  # of the controller FMU by name; None where it is not known
    controller: str  # where it is known from, as displayed


def read_log(
    path: Path,
    description: logs.Description,
    learned: LearnedFile,
    on_findings: Callable[[Iterable[logs.Finding]], object] = lambda _: None,
) -> LogInLoop:
    """Read a log of a learned drive; its controller is the one given, or that of the file."""
    kind: logs.Motion = "rotary" if learned.rotary else "linear"
    reading, findings = logs.read_and_check(path, description, known=learned.with_position_force)
    if kind != reading.recording.motion and {"position", "velocity"} & {*reading.assumed}:
        described = replace(description, motion=kind)
        reading, findings = logs.read_and_check(path, described, known=learned.with_position_force)
    logs.raise_errors(path, findings)
    reading, findings = in_time(reading, findings)
    on_findings(findings)
    recording = reading.recording
    if recording.motion != kind:
        raise UsageError(
            f"{path}: a log of a {recording.motion} drive, but {learned.path} has a {kind} one;"
            f" give <motion {kind}>, or the log of the drive that was learned"
        )
    if not learned.drive["m"] and recording.friction is None:
        raise UsageError(
            f"{learned.path}: has no mass, as it was learned from measured friction; expected a "
            f"log of friction, got one of force in {path}"
        )
    gains = reading.controller.parameters()
    name = f"the {reading.controller.kind} controller given"
    if gains is None and learned.loop is not None:
        own = controller_of(learned.loop)
        if own.needs and getattr(recording, own.needs) is not None:
            recording, own = with_velocity_command(recording, own)
            reading, gains = replace(reading, recording=recording), own.parameters()
            name = f"the {own.kind} controller of {learned.path.name}"
    return LogInLoop(reading, gains, name if gains else "not known")


def controller_of(loop: VelocityLoop) -> Controller:
    """Return the controller of a loop."""
    gains = {key: getattr(loop, key) for key in ("K_p", "K_i", "tau_f", "T_s")}
    if not loop.K_x:
        return Controller("PI", **gains)
    outer = {key: getattr(loop, key) for key in ("K_x", "velocity_feedforward")}
    return Controller("cascade", **gains, **outer)


def validate_log(log: LogInLoop, learned: LearnedFile) -> LogPrediction:
    """Return what the learned drive predicts of a log."""
    drive = drive_of(learned)
    with candidate_fmus(drive.law) as fmus:
        return predict_log(
            fmus, log.reading.recording, log.gains, drive, errors=learned.drive_errors
        )


def drive_of(learned: LearnedFile) -> LearnedDrive:
    """Return the drive of a file, and the compensator as it is exported."""
    return LearnedDrive(learned.law.name, learned.drive, learned.feedforward, learned.loop)


def compare_logs(compensated: LogInLoop, without: LogInLoop, learned: LearnedFile) -> LogComparison:
    """Return what the compensator brought in one log against another without it.

    The simulated prediction runs the learned drive along the log without compensator, in its loop.
    Raises UsageError when their commands differ, or were not logged.
    """
    plain, other = without.reading.recording, compensated.reading.recording
    had, has = (one.added_force is not None and np.any(one.added_force) for one in (plain, other))
    if had and not has and other.added_force is not None:
        raise UsageError(
            f"{plain.source} has an added force, {other.source} has none;"
            " the logs with and without the compensator look swapped"
        )
    other, stretches = common(plain, other)
    found = compare(plain, other, stretches)
    if without.gains is None:
        return found
    drive, scale = drive_of(learned), recording_scale(plain)
    with candidate_fmus(drive.law) as fmus:
        scaled, gains = scale.recording(plain), scale.values(without.gains)
        gains = scale.restored(check_controller(fmus, scaled, gains).gains)
        try:
            runs = simulate(fmus, plain, gains, drive, force_limit=without.reading.force_limit)
        except cosim.SimulationError as fault:
            return replace(found, fault=f"{without.controller}: {fault}")
    simulated = {name: replace(plain, position=run.encoder) for name, run in runs.items()}
    samples = np.concatenate([np.arange(run.first, run.first + run.n) for run in stretches])
    prediction = compared(
        simulated[NONE], simulated[FEEDFORWARD], samples, samples, part=found.part
    )
    alone = "simulated is the feedforward alone, without the observer that the file also has"
    return replace(found, simulated=prediction, fault=alone * ("observer" in learned.document))
