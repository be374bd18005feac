"""What ``stickslip learn`` does with a log: read, check, learn, guard, write."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stickslip import models
from stickslip.catalog.parameters import LUGRE, friction_law
from stickslip.fmi.files import atomic_write
from stickslip.identification.estimation import (
    CriterionName,
    Estimation,
    Search,
    Task,
    candidate_fmus,
)
from stickslip.identification.estimation import learn as estimate
from stickslip.identification.fitting.identifiability import NOT_VISIBLE
from stickslip.logs import (
    Description,
    Finding,
    Reading,
    aligned,
    check_recording,
    check_units,
    implausible_mass,
    raise_errors,
    read_recording,
    samples_late,
)
from stickslip.pipeline.log_trial import LogTrial, try_compensator
from stickslip.report.learned import FILES as REPORT
from stickslip.report.learned import write_estimation_report
from stickslip.report.learned.content import compensation
from stickslip.results.folder import staged
from stickslip.results.learned import estimation_document, trial_document

FILES = ("learned.json", "compensator.fmu", *REPORT)
"""What ``write_learned`` writes or removes."""


@dataclass(frozen=True)
class LogLearning:
    """All that a log gave.

    Attributes
    ----------
    findings : of reading and checks
    trial : of the compensator in a loop; None where no loop can be closed
    """

    reading: Reading
    findings: tuple[Finding, ...]
    estimation: Estimation
    trial: LogTrial | None
    seed: int

    @property
    def compensator(self) -> dict[str, float]:
        """The compensator's parameters by name, in SI units, at the share of its force tried."""
        share = self.trial.benefit.share if self.trial else 1.0
        return friction_law().share(self.estimation.compensator, share)

    def with_whole_force(self) -> LogLearning:
        """Return the same with the compensator at its whole force, whatever that does."""
        if self.trial is None:
            return self
        benefit = self.trial.benefit
        whole = replace(self.trial, benefit=replace(benefit, share=1.0, rows=benefit.full))
        return replace(self, trial=whole)

    @property
    def refusal(self) -> str:
        """Why the compensator should not be written; empty where nothing speaks against it."""
        mass = self.estimation.known.get("m")
        question = implausible_mass(self.reading, mass.low, mass.high) if mass else None
        if question and question.severity == "error":
            return str(question)
        for fault in self.estimation.faults:
            if fault.spoils == "values":
                return f"{fault.what}: {fault.figure}; {fault.advice}"
        return self.trial.benefit.refusal if self.trial and not self.trial.benefit.harmless else ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What should be known before the compensator is used, a line each."""
        guesses = [
            f"{name} is not visible in this log; the compensator takes {known.value:.4g}: "
            f"{known.sentence}"
            for name, known in self.estimation.known.items()
            if name in LUGRE and known.visible == NOT_VISIBLE
        ]
        trial = self.trial
        if trial is None:
            return (*guesses, "no velocity loop can be closed, so the compensator is not tried")
        if not trial.known:
            guesses.append(
                "no velocity loop of the log is known, so the compensator is tried in one designed "
                f"for the learned mass, K_p = {trial.loop.K_p:.4g} and K_i = {trial.loop.K_i:.4g}"
            )
        return (*guesses, *trial.warnings)


def read_and_check(path: Path, description: Description) -> tuple[Reading, tuple[Finding, ...]]:
    """Read a log and return it with its findings, errors included.

    Raises
    ------
    RecordingError, UsageError
        When it cannot be read.
    """
    reading = read_recording(path, description, strict=False)
    checks = check_recording(reading.recording, reading.controller, reading.force_limit)
    return reading, (*reading.findings, *check_units(reading), *checks)


def learn(
    path: Path | str,
    description: Description | None = None,
    *,
    criterion: CriterionName = "auto",
    seed: int = 0,
    seeds: int = 1,
    search: Search | None = None,
    on_findings: Callable[[Iterable[Finding]], object] = lambda _: None,
    on_stage: Callable[[str], object] = lambda _: None,
) -> LogLearning:
    """Learn a drive's parameters from a log of it; options are those of ``estimation.Task``.

    Parameters
    ----------
    path : CSV, Parquet or MAT file
    description : of its columns and of the controller; by default the columns are detected

    Raises
    ------
    RecordingError, UsageError
        When the log cannot be read, or lacks a signal.
    IdentificationError
        When it does not show a drive that slides.
    """
    on_stage("reading the log")
    path = Path(path)
    reading, findings = read_and_check(path, description or Description())
    raise_errors(path, findings)
    on_findings(findings)
    recording = aligned(reading.recording, samples_late(reading.recording))
    reading = replace(reading, recording=recording)
    with candidate_fmus() as fmus:
        task = Task(
            fmus,
            reading.recording,
            reading.controller.parameters(),
            criterion=criterion,
            seed=seed,
            seeds=seeds,
            search=search or Search(),
            faults=tuple(finding for finding in findings if finding.spoils),
        )
        estimation = estimate(task, on_stage)
    on_stage("trying the compensator")
    trial = try_compensator(reading, estimation)
    return LogLearning(reading, findings, estimation, trial, seed)


def write_learned(learned: LogLearning, folder: Path, *, force: bool = False) -> None:
    """Write learned.json, report and, if it does no harm or is forced, compensator.fmu.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    command = {"name": "learn", "log": learned.estimation.recording.source, "seed": learned.seed}
    if force:
        learned = learned.with_whole_force()
    with staged(folder, command, without=["compensator.fmu"]) as staging:
        atomic_write(
            staging / "learned.json", json.dumps(learned_document(learned), indent=2) + "\n"
        )
        if force or not learned.refusal:
            models.build_fmu("compensator", staging, start=learned.compensator)
        further = [compensation(learned.trial.benefit)] if learned.trial else []
        write_estimation_report(learned.estimation, learned.findings, staging, further)


def learned_document(learned: LogLearning) -> dict[str, Any]:
    """Return the content of learned.json."""
    trial = learned.trial
    loop = trial.loop if trial and trial.known else None
    document = estimation_document(learned.estimation, loop, learned.seed)
    document["refusal"] = learned.refusal
    if trial:
        document |= trial_document(trial.benefit, trial.command, trial.datasheet)
    return document
