"""What ``stickslip learn`` does with a log or a rig: read, check, learn, try the compensator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip import cosim
from stickslip.errors import UsageError
from stickslip.evaluation.tracking import (
    LearnedDrive,
    Tracking,
    TrackingError,
    commanded_position,
    commanded_velocity,
    feedforward,
    measured_errors,
    remedied,
    simulate,
)
from stickslip.fmi.files import digest
from stickslip.identification.criteria.controller_check import in_time
from stickslip.identification.criteria.known_loop import is_running
from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.identification.estimation import CriterionName, LearnSettings, Search
from stickslip.identification.sliding.checked_logs import Checked, Refused, check_logs, joined
from stickslip.identification.sliding.position_force import PositionForce, with_position_force
from stickslip.logs import (
    Description,
    Finding,
    Reading,
    Recording,
    check_recording,
    load_description,
    raise_errors,
    read_and_check,
)
from stickslip.logs.checks import visibility
from stickslip.logs.plausibility import implausible_mass
from stickslip.logs.sets import Log, logs_of
from stickslip.loops.drive_loop import DriveLoop
from stickslip.loops.family_cost import FamilyCost
from stickslip.loops.other_gains import try_other_gains
from stickslip.output import SILENT, Progress, counted_steps
from stickslip.planning import LINEAR, Limits
from stickslip.rigs.contract import Rig
from stickslip.servo.axis import ControlError
from stickslip.servo.observer import masses_between
from stickslip.studies.learn.controller_findings import check_rig
from stickslip.studies.learn.learned import LearnedFromRecording, learn_recording
from stickslip.studies.learn.predicted_logs import predicted_logs
from stickslip.studies.learn.recorded import read_rig
from stickslip.studies.learn.verdict import loop_share
from stickslip.thresholds import control_match, harm
from stickslip.trial.benefit import bench_of
from stickslip.trial.candidates import law_of
from stickslip.trial.compensator_trial import loops_of_log, try_compensator
from stickslip.trial.family import Command
from stickslip.trial.observed import BOTH, FEEDFORWARD
from stickslip.trial.own_motions import read_motions

GENTLE = 0.1
"""Least time of a ramp [s] where no command was logged: in quicker ones the loop's lag hides what
friction does (in the log of the tests 0.66 mm/s with the feedforward and 0.64 without)."""
SETTLING = 0.02
"""Share of a log that does not count where it begins in motion: the compensator has to start."""


def with_trial(
    reading: Reading,
    learned: LearnedFromRecording,
    settings: LearnSettings,
    own: tuple[Command, ...] = (),
) -> LearnedFromRecording:
    """Try a learned compensator where a loop can be closed; see ``try_compensator``."""
    estimation = learned.estimation
    mass = estimation.known.get("m")
    question = implausible_mass(reading, mass.low, mass.high) if mass else None
    doubt = str(question) if question and question.severity == "error" else ""
    learned = replace(learned, asked=settings.compensator, implausible=doubt)
    if isinstance(learned.loops, ControlError):
        return learned
    trial = try_compensator(reading, estimation, learned.loops.compensated, settings, own=own)
    return replace(learned, trial=trial)


def with_other_gains(
    learned: LearnedFromRecording, settings: LearnSettings
) -> LearnedFromRecording:
    """Try other gains of a known loop, with what is written, unless a part of that is refused."""
    loop, trial, written = learned.known_loop, learned.trial, learned.writes()
    if settings.fixed_gains or loop is None or trial is None or written != learned.choice:
        return learned
    law, mass, one = learned.estimation.law, learned.estimation.known["m"], learned.feedforward
    own = f"{one.model}_{one.law}" if one.law else ""  # FMU of another law in the bench's folder
    start = DriveLoop(
        loop,
        law,
        replace(one, file=own) if written in (FEEDFORWARD, BOTH) else None,
        learned.observer,
        share=learned.benefit.share if learned.benefit else 1.0,
    )
    masses = masses_between(mass.low / loop.axis.m, mass.high / loop.axis.m)
    with (
        bench_of(
            law,
            loop,
            learned.friction,
            trial.drives,
            command=trial.command,
            datasheet=trial.datasheet,
            own=trial.own,
            workers=settings.workers,
        ) as bench,
        FamilyCost(bench, start, masses, ()) as cost,
    ):
        return replace(learned, other_gains=try_other_gains(cost))


def with_tracking(reading: Reading, learned: LearnedFromRecording) -> LearnedFromRecording:
    """Return the same with the tracking in the log's loop, or in one that was designed for it.

    The command is that of the log, or, where none was logged, a trapezoid at its speed. Where no
    loop can be closed there is none. A compensator is not recommended for a loop that runs away.
    """
    if isinstance(learned.loops, ControlError) or learned.trial is None:
        return learned
    loop, estimation = learned.loops.compensated, learned.estimation
    kind, recording = reading.controller.kind, estimation.recording.first
    command, has_command = "the log's own command", True
    if recording.velocity_command is None and recording.position_command is None:
        trapezoid, has_command = learned.trial.command, False
        slope = min(trapezoid.slope, trapezoid.height / GENTLE)
        trapezoid = replace(trapezoid, slope=slope)
        command = "a trapezoid at the log's speed, as no command was logged"
        n = round((trapezoid.corners()[-1] + trapezoid.begin) / loop.T_s) + 1
        t = np.arange(n) * loop.T_s
        recording = _at_rest(recording, t, trapezoid.sample(t))
    known = estimation.gains is not None and has_command
    if known:
        gains, name = dict(estimation.gains or {}), f"the log's {kind} controller"
        check = estimation.controller
        if check is not None and check.error > 0.0:
            differs = "commands the logged force within"
            if check.error > control_match.NEAR:
                differs = "differs from the logged force by"
            name += f", which {differs} {max(100.0 * check.error, 0.01):.2g} %"
    else:
        gains = {"K_p": loop.K_p, "K_i": loop.K_i, "tau_f": loop.tau_f, "T_s": loop.T_s}
        name = (
            "a PI velocity controller designed for the learned mass, as the log's is not known: "
            f"K_p = {loop.K_p:.4g}, K_i = {loop.K_i:.4g}"
        )
        recording = _at_rest(recording, recording.t, commanded_velocity(recording))
    reference = loop if learned.loops.known or not known else None
    drive = LearnedDrive(estimation.law.name, estimation.parameters, learned.feedforward, reference)
    try:
        with candidate_fmus(drive.law) as fmus:
            runs = simulate(fmus, recording, gains, drive, force_limit=reading.force_limit)
            better = remedied(fmus, recording, gains, drive, force_limit=reading.force_limit)
    except cosim.SimulationError as fault:
        what = learned.implausible or f"in the loop of {name}: {fault}"
        return replace(learned, implausible=what)
    v_cmd, x_cmd = commanded_velocity(recording), commanded_position(recording)
    begin = round(SETTLING * len(v_cmd)) if is_running(gains) else 0
    used = slice(begin, None)
    measured = None
    if known:
        errors = measured_errors(recording, v_cmd, x_cmd)
        measured = TrackingError.of(*(error[used] for error in errors))
    tracking = Tracking(
        recording.t,
        v_cmd,
        {name: run.velocity for name, run in runs.items()},
        {name: run.position - x_cmd for name, run in runs.items()},
        used=used,
        loop=name,
        command=command,
        known=known,
        measured=measured,
        remedies={name: run.error(v_cmd, x_cmd, used) for name, run in better.items()},
        by_position=any(gains.get(name) for name in ("K_x", "P_x", "I_x")),
        force=float(np.max(np.abs(feedforward(recording, drive)))),
    )
    share = loop_share(tracking, recording.motion, "")
    what = learned.implausible or (share.mismatch if share else "")
    return replace(learned, tracking=tracking, implausible=what)


def _at_rest(recording: Recording, t: np.ndarray, v_cmd: np.ndarray) -> Recording:
    """Return an experiment from rest that commands velocities (n,) [m/s]."""
    return Recording(
        t,
        np.zeros_like(t),
        velocity_command=v_cmd,
        encoder_step=recording.encoder_step,
        motion=recording.motion,
        source=recording.source,
    )


def learn(
    source: Path | str | Log | Rig | Sequence[Path | str | Log],
    description: Description | Path | str | None = None,
    *,
    law: str = "auto",
    compensator: str = "auto",
    fixed_gains: bool = False,
    friction_range: tuple[float, float] | None = None,
    absent: Sequence[str] = (),
    motions: Sequence[Path | str] = (),
    validate: Sequence[Path | str | Log] = (),
    criterion: CriterionName = "auto",
    limits: Limits = LINEAR,
    search: Search | None = None,
    seed: int = 0,
    progress: Progress = SILENT,
) -> LearnedFromRecording:
    """Learn a drive from a log of it, or several, or on a rig.

    Parameters
    ----------
    source : CSV, Parquet or MAT file, or a rig, which then runs one experiment; or several files,
        folders, tables of logs (see ``logs_of``), or ``Log`` objects, each with a description of
        its own. The compensator is tried in the loop of the first log.
    description : of its columns and of the controller, or its file (TOML); by default the columns
        are detected
    law, compensator, fixed_gains, friction_range, absent, criterion, limits, search, seed :
        as of ``LearnSettings``; law and compensator are chosen unless they are given
    motions : files of commands, such as logs or plans, of the motions that the drive will make;
        compensators are then compared in these alone
    validate : logs whose force is predicted, but not learned from
    progress : is told of stages, findings and generations

    Raises
    ------
    RecordingError, UsageError
        When the log cannot be read, or lacks a signal, or there is no such compensator.
    IdentificationError
        When it does not show a drive that slides.
    RigError
        When the experiment on the rig did not end as commanded.
    """
    if isinstance(description, Path | str):
        description = load_description(Path(description))
    asked = LearnSettings(
        law=law,
        compensator=compensator,
        fixed_gains=fixed_gains,
        friction_range=friction_range or harm.levels(),
        absent=absent,
        criterion=criterion,
        limits=limits,
        search=search or Search(),
        seed=seed,
    )
    chosen = replace(asked, law=law_of(asked.compensator, asked.law, asked.absent))
    # Threads of linear algebra would wait for those of other work on the same cores.
    with threadpool_limits(limits=1, user_api="blas"):
        given = description or Description()
        others: list[Log] = []
        hashes: dict[str, str] = {}
        left_out: tuple[Finding, ...] = ()
        if isinstance(source, Rig):
            progress.stage("recording the drive")
            reading = read_rig(source, chosen.limits)
            reading = replace(reading, recording=with_position_force(reading.recording))
            found = check_recording(reading.recording, reading.controller, reading.force_limit)
            raise_errors(source.name, found)
            reading, found = in_time(reading, found)
            checked = [Checked(reading, (*found, *check_rig(reading)))]
        else:
            progress.stage("reading the log")
            logs = _logs(source, given)
            checked, left_out = _read_all([log for log in logs if not log.validates])
            hashes = {log.path.name: digest(log.path) for log in logs if not log.validates}
            others = [log for log in logs if log.validates]
            others += _logs(validate, given)
        own = read_motions(motions, given, checked[0].reading.recording)
        learned = _learn_together(checked, left_out, chosen, progress)
        contradicting = {one.log: one for one in learned.estimation.faults if one.log}
        kept = [one for one in checked if one.reading.recording.source not in contradicting]
        if contradicting and len(kept) > 1:  # they are at least half of the logs
            left_out += tuple(
                Finding("warning", f"{one.log} is left out: {one.what}", one.figure, one.advice)
                for one in contradicting.values()
            )
            checked = kept
            learned = _learn_together(checked, left_out, chosen, progress)
        reading, recording = checked[0].reading, joined(checked)
        held_out = [_held_out(log, learned.estimation.position_force) for log in others]
        predicted = predicted_logs(learned.estimation, held_out, chosen.workers)
        learned = replace(learned, predicted=tuple(predicted), hashes=hashes)
        progress.stage("trying compensators")
        with counted_steps():
            tried = with_trial(replace(reading, recording=recording), learned, chosen, own)
        progress.stage("trying other gains of the controller")
        with counted_steps():
            return with_tracking(reading, with_other_gains(tried, chosen))


def _learn_together(
    checked: Sequence[Checked],
    left_out: tuple[Finding, ...],
    settings: LearnSettings,
    progress: Progress,
) -> LearnedFromRecording:
    """Return what logs show together, without a trial of compensators."""
    recording, controllers = joined(checked), [one.gains for one in checked]
    findings = (*left_out, *_of_all(checked, recording))
    progress.findings(findings)
    return learn_recording(
        recording,
        controllers[0] if all(controllers) else None,
        partial(loops_of_log, checked[0].reading),
        findings,
        settings=settings,
        progress=progress,
    )


def _logs(
    source: Path | str | Log | Sequence[Path | str | Log], description: Description
) -> list[Log]:
    """Return the logs of files, folders and tables."""
    several = [source] if isinstance(source, Path | str | Log) else source
    return [
        log
        for one in several
        for log in ([one] if isinstance(one, Log) else logs_of([Path(one)], description))
    ]


def _read_all(logs: Sequence[Log]) -> tuple[list[Checked], tuple[Finding, ...]]:
    """Return the logs with their force in time, and warnings of those that are left out.

    Of several logs, those that cannot be read or have a fault are left out where most have none.
    """
    if not logs:
        raise UsageError("expected a log to learn from; got none")
    read = [*check_logs(logs)]
    refused = [one for one in read if isinstance(one, Refused)]
    checked = [_in_time(one) for one in read if isinstance(one, Checked)]
    if 2 * len(refused) > len(logs) or len(checked) < min(len(logs), 2):
        raise refused[0].error
    left_out: dict[str, list[str]] = {"": [str(one.error) for one in refused]} if refused else {}
    sound = [one for one in checked if one.fault is None]
    if len(sound) >= max(2.0, 0.5 * len(logs)):
        for one in checked:
            if one.fault is not None:
                reason = f"{one.reading.recording.source}: {one.fault}"
                left_out.setdefault(one.fault.what, []).append(reason)
        checked = sound
    return checked, tuple(
        Finding("warning", f"{len(some)} of {len(logs)} logs left out", f"the first is {some[0]}")
        for some in left_out.values()
    )


def _held_out(log: Log, force: PositionForce | None) -> Recording:
    """Return a log that is only predicted, checked with the force of position that was learned."""

    def known(recording: Recording) -> Recording:
        return recording if force is None else with_position_force(recording, force)

    reading, findings = read_and_check(log.path, log.description, known=known)
    raise_errors(log.path, findings)
    return in_time(reading, findings)[0].recording


def _in_time(log: Checked) -> Checked:
    reading, findings = in_time(log.reading, log.findings)
    return replace(log, reading=reading, findings=findings)


def _of_all(checked: Sequence[Checked], recording: Recording) -> tuple[Finding, ...]:
    """Return the findings: of several logs warnings, each once, and what they show together."""
    if len(checked) == 1:
        return checked[0].findings
    alike: dict[str, dict[str, Finding]] = {}
    for log in checked:
        for one in log.findings:
            if one.severity != "note":
                alike.setdefault(one.what, {}).setdefault(log.reading.recording.source, one)
    found = []
    for several in alike.values():
        source, first = next(iter(several.items()))
        if len(several) > 1:
            source = f"{len(several)} of {len(checked)} logs, such as {source}"
        found.append(replace(first, what=f"{source}: {first.what}"))
    return (*found, *visibility(recording))
