"""Tracking without and with a learned compensator in the loop of its log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip import cosim
from stickslip.evaluation.tracking import (
    LearnedDrive,
    Tracking,
    TrackingError,
    commanded_position,
    commanded_velocity,
    measured_errors,
    simulate,
)
from stickslip.identification.criteria.known_loop import is_running
from stickslip.identification.estimation import candidate_fmus
from stickslip.logs import Reading, Recording
from stickslip.servo.axis import ControlError
from stickslip.studies.learn.learned import LearnedFromRecording
from stickslip.thresholds import control_match

SETTLING = 0.02
"""Share of a log that does not count where it begins in motion: the compensator has to start."""


def with_tracking(reading: Reading, learned: LearnedFromRecording) -> LearnedFromRecording:
    """Return the same with the tracking in the log's loop, or in one that was designed for it.

    The command is that of the log, or, where none was logged, a trapezoid at its speed. Where no
    loop can be closed there is none. A compensator is not recommended for a loop that runs away.
    """
    if isinstance(learned.loops, ControlError) or learned.trial is None:
        return learned
    loop, estimation = learned.loops.compensated, learned.estimation
    kind, recording = reading.controller.kind, estimation.recording
    command, has_command = "the log's own command", True
    if recording.velocity_command is None and recording.position_command is None:
        trapezoid, has_command = learned.trial.command, False
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
    )
    return replace(learned, tracking=tracking)


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
