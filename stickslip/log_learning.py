"""What ``stickslip learn`` does with a log: read, check, learn, guard, write."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import models
from cosim.control import Axis, ControlError, VelocityLoop, close_velocity_loop
from stickslip.errors import HarmfulError
from stickslip.estimation import Estimation, JudgeName, Search, Task, candidate_fmus, learn
from stickslip.guards import Trial, inspect, refuse_worse
from stickslip.learned import estimation_document
from stickslip.learned_report import FILES as REPORT
from stickslip.learned_report import write_estimation_report
from stickslip.loop import build_fmus
from stickslip.parameters import LUGRE
from stickslip.recording import (
    Description,
    Finding,
    Reading,
    check_recording,
    check_units,
    implausible_mass,
    raise_errors,
    read_recording,
)
from stickslip.result_folder import staged
from stickslip.setup import VALIDATION, Datasheet
from toolchain import write_whole

FILES = ("learned.json", "compensator.fmu", *REPORT)
"""What ``write_learned`` writes or removes."""


@dataclass(frozen=True)
class LogLearning:
    """All that a log gave.

    Attributes
    ----------
    findings : of reading and checks
    loop : the velocity loop of the log's controller around the learned axis; None where it has none
    """

    reading: Reading
    findings: tuple[Finding, ...]
    estimation: Estimation
    loop: VelocityLoop | None
    seed: int

    @property
    def compensator(self) -> dict[str, float]:
        """The compensator's parameters by name, in SI units."""
        return self.estimation.compensator


def read_and_check(path: Path, description: Description) -> tuple[Reading, tuple[Finding, ...]]:
    """Read a log and return it with what is to be said of it, errors included.

    Raises
    ------
    RecordingError, UsageError
        When it cannot be read.
    """
    reading = read_recording(path, description, strict=False)
    checks = check_recording(reading.recording, reading.controller, reading.force_limit)
    return reading, (*reading.findings, *check_units(reading), *checks)


def learn_from_log(
    path: Path,
    description: Description,
    *,
    judge: JudgeName = "auto",
    seed: int = 0,
    seeds: int = 1,
    search: Search | None = None,
    on_findings: Callable[[Iterable[Finding]], object] = lambda _: None,
    on_stage: Callable[[str], object] = lambda _: None,
) -> LogLearning:
    """Learn a drive's parameters from a log of it; options are those of ``estimation.Task``.

    Raises
    ------
    RecordingError, UsageError
        When the log cannot be read, or lacks a signal.
    IdentificationError
        When it does not show a drive that slides.
    """
    on_stage("reading the log")
    reading, findings = read_and_check(path, description)
    raise_errors(path, findings)
    on_findings(findings)
    with candidate_fmus() as fmus:
        task = Task(
            fmus,
            reading.recording,
            reading.controller.parameters(),
            judge=judge,
            seed=seed,
            seeds=seeds,
            search=search or Search(),
        )
        estimation = learn(task, on_stage)
    return LogLearning(reading, findings, estimation, _loop(reading, estimation), seed)


def write_learned(learned: LogLearning, folder: Path, *, force: bool = False) -> list[str]:
    """Write learned.json, report and, if it does no harm, compensator.fmu; return warnings.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    document = estimation_document(learned.estimation, learned.loop, learned.seed)
    warnings, harmless = _guarded(learned)
    command = {"name": "learn", "log": learned.estimation.recording.source, "seed": learned.seed}
    with staged(folder, command, without=["compensator.fmu"]) as desk:
        write_whole(desk / "learned.json", json.dumps(document, indent=2) + "\n")
        if harmless or force:
            models.build_fmu("compensator", desk, start=learned.compensator)
        write_estimation_report(learned.estimation, learned.findings, desk)
    return warnings


def _guarded(learned: LogLearning) -> tuple[list[str], bool]:
    """Return what the guards say, and whether the compensator may leave."""
    said = [
        f"{name} is not visible in this log, the compensator's value is a guess: "
        f"{learned.estimation.known[name].sentence}"
        for name in LUGRE
        if learned.estimation.known[name].visible == "not visible"
    ]
    mass = learned.estimation.known.get("m")
    question = implausible_mass(learned.reading, mass.low, mass.high) if mass else None
    if question and question.severity == "error":
        return [*said, f"compensator.fmu is not written: {question}"], False
    if learned.loop is None:
        said.append(
            "no stable velocity loop is known, so whether the compensator helps is unchecked; give "
            "the gains of a controller of velocity, or a cascade"
        )
        return said, True
    with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
        build_fmus(Path(folder), {})
        trial = _trial(learned, learned.loop, Path(folder))
        errors = {
            name: learned.estimation.known[name].standard_error
            for name in LUGRE
            if learned.estimation.known[name].visible != "not visible"
        }
        said += [str(finding) for finding in inspect(trial, errors)]
        try:
            refuse_worse(trial)
        except HarmfulError as error:
            return [*said, f"compensator.fmu is not written: {error}"], False
    return said, True


def _trial(learned: LogLearning, loop: VelocityLoop, fmus: Path) -> Trial:
    """Return the validation command at the log's own speed, in the log's own loop."""
    recording = learned.estimation.recording
    velocity = learned.estimation.figures.velocity_recorded
    top = float(np.quantile(np.abs(velocity), 0.99))
    scale = top / VALIDATION.height
    duration = VALIDATION.corners()[-1] + VALIDATION.begin
    t = np.arange(round(duration / loop.T_s) + 1) * loop.T_s
    strongest = float(np.max(np.abs(learned.estimation.figures.shown)))
    limit = learned.reading.force_limit or 1e3 * strongest
    step = recording.encoder_step or 1e-6 * top
    sheet = Datasheet(peak_force=limit, tau_i=loop.axis.tau_i, encoder_step=step)
    return Trial(
        fmus,
        loop,
        learned.compensator,
        learned.compensator,
        scale * VALIDATION.sample(t),
        datasheet=sheet,
    )


def _loop(reading: Reading, estimation: Estimation) -> VelocityLoop | None:
    """Return the velocity loop of the log's controller, None where there is none or it fails."""
    controller, known = reading.controller, estimation.known
    if "m" not in known or not controller.K_p or controller.P_x or controller.I_x:
        return None
    T_s = controller.T_s or estimation.recording.T_s
    axis = Axis(known["m"].value, max(known["b"].value, 0.0), reading.tau_i or 0.0)
    try:
        return close_velocity_loop(axis, T_s, controller.tau_f, controller.K_p, controller.K_i)
    except ControlError:
        return None
