"""Faults of a recording, and what it can show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from stickslip.fmi.messages import quantity, scaled_unit
from stickslip.logs.controller import Controller
from stickslip.logs.delay import (
    Delay,
    aligned,
    force_delay,
    late_beyond,
    samples_late,
    signal_delay,
)
from stickslip.logs.excitation import Excitation, excitation
from stickslip.logs.finding import Finding, Severity
from stickslip.logs.force_path import force_path
from stickslip.logs.lost_rows import lost_rows
from stickslip.logs.motion import kinematics
from stickslip.logs.recording import Recording
from stickslip.logs.saturation import saturation
from stickslip.thresholds import log_content

SIGNALS = tuple(
    field.name for field in fields(Recording) if field.type == "Array | None"
)  # of a recording, by role
PLAN = "stickslip plan --show"
ONE_WAY = "F_c and the constant force cannot be told apart"


def check_recording(
    recording: Recording, controller: Controller | None = None, force_limit: float | None = None
) -> tuple[Finding, ...]:
    """Return the findings on a recording before learning.

    Parameters
    ----------
    recording : on its even grid
    controller : that was in use
    force_limit : of motor or amplifier [N]
    """
    controller = controller or Controller()
    if force_limit is None and np.isfinite(controller.u_max):
        force_limit = controller.u_max
    findings = [*_signals(recording, controller)]
    if any(finding.severity == "error" for finding in findings):
        return tuple(findings)
    shown = excitation(recording)
    late = samples_late(recording)
    lost = lost_rows(recording)
    return (
        *findings,
        *([lost] if lost else force_path(aligned(recording, late))),  # the cause of the rest
        *saturation(recording, force_limit),
        *_quantisation(recording, shown),
        *_delays(recording, late),
        *_visibility(recording, shown),
    )


def _signals(recording: Recording, controller: Controller) -> Iterator[Finding]:
    """Yield what is missing, not finite, constant or short."""
    for name in SIGNALS:
        signal = getattr(recording, name)
        if signal is None:
            continue
        if len(signal) != len(recording.t):
            figure = f"{len(signal)} values, expected {len(recording.t)}"
            yield Finding("error", f"{name} is not as long as the time", figure)
        elif not np.isfinite(signal).all():
            where = f"the first at {recording.t[np.argmin(np.isfinite(signal))]:.6g} s"
            yield Finding("error", f"{name} holds values that are not finite", where)
        elif np.ptp(signal) == 0:
            severity: Severity = (
                "error" if name in ("position", "velocity", "force", "friction") else "warning"
            )
            figure = f"{signal[0]:.6g} throughout"
            yield Finding(severity, f"{name} never changes", figure, "log another column")
    if recording.position is None and recording.velocity is None:
        yield Finding("error", "neither position nor velocity", advice="log one")
    if recording.force is None and recording.friction is None:
        if recording.force_command is None and controller.kind == "none":
            advice = "log the motor's current, or give --controller"
            yield Finding("error", "neither force nor friction", advice=advice)
        else:
            what = "no force was measured, only commanded"
            yield Finding("note", what, advice="the amplifier is taken to follow")
    if controller.needs and getattr(recording, controller.needs) is None:
        what = f"a {controller.kind} controller, but no {controller.needs}"
        yield Finding("error", what, advice=f"give --column {controller.needs}=NAME")
    duration = float(recording.t[-1])
    if duration < log_content.DURATION or len(recording.t) < log_content.SAMPLES:
        figure = f"{duration:.3g} s, {len(recording.t)} samples"
        yield Finding("warning", "the recording is short", figure, "log 10 s or more")


def _quantisation(recording: Recording, shown: Excitation) -> Iterator[Finding]:
    """Yield the resolution of the position relative to the motion."""
    step = recording.encoder_step
    if not step or recording.position is None:
        return
    size = quantity(step, "rad" if recording.rotary else "m", 4)
    share = f"{100.0 * step / recording.T_s / max(shown.top_speed, 1e-300):.2g} %"
    figure = f"step {size}; in the difference of two samples, {share} of the top speed"
    travel = float(np.ptp(recording.position)) / step
    if travel < log_content.TRAVEL:
        advice = "move farther, or use a finer encoder"
        yield Finding("warning", "the whole travel is few encoder steps", f"{travel:.0f}", advice)
    else:
        yield Finding("note", "the position is quantised", figure)


def _delays(recording: Recording, late: int) -> Iterator[Finding]:
    """Yield delays of signals relative to each other."""
    delay = force_delay(recording)
    if beyond := late_beyond(recording):
        figure = f"{1e3 * beyond:.4g} ms, the largest that is looked for, explains most of it"
        advice = "log force and position of the same instants, or shift the force by its delay"
        what = "the delay of the force ends at the bound of its search"
        yield Finding("warning", what, figure, advice, spoils="values")
    elif delay and not delay.at_bound and (late or not delay.is_large(recording.T_s)):
        yield _delayed("force", "the motion", delay, recording.T_s, taken_out=late)
    if recording.position is not None and recording.velocity is not None:
        motion = kinematics(recording)
        other = kinematics(Recording(recording.t, velocity=recording.velocity))
        delay = signal_delay(recording.t, motion.v, other.v)
        if delay and not delay.at_bound:
            yield _delayed("velocity", "the position's derivative", delay, recording.T_s)


def _delayed(name: str, other: str, delay: Delay, T_s: float, taken_out: int = 0) -> Finding:
    figure = f"{delay.value / T_s:.2f} +- {delay.standard_error / T_s:.2f} samples"
    way = "delayed" if delay.value >= 0 else "early (negative delay)"
    if taken_out:
        advice = f"{1e3 * taken_out * T_s:.4g} ms are removed before learning"
        return Finding("warning", f"{name} is {way} relative to {other}", figure, advice)
    if not delay.known(T_s):
        return Finding("note", f"the delay of {name} relative to {other} is not determined", figure)
    return Finding("note", f"{name} is {way} relative to {other}", figure)


def _visibility(recording: Recording, shown: Excitation) -> Iterator[Finding]:
    """Yield what can and cannot be identified, and which experiment shows the rest."""
    unit = "rad" if recording.rotary else "m"
    low, high = shown.speeds
    factor, speed = scaled_unit(f"{unit}/s", high)
    speeds = f"{factor * low:.2g} to {factor * high:.3g} {speed}"
    figure = f"{shown.moving:.1%} of the time, 90 % of it at {speeds}"
    advice = "move faster or longer; only presliding may be identifiable"
    fine = shown.moving >= log_content.MOVING
    words = "the drive moves", "the drive hardly moves"
    yield Finding.either(fine, words, figure, advice)
    if shown.spacing < log_content.SPACING:
        figure = f"{shown.spacing:.0f} samples between two"
        what = "reversals are too fast for the sample rate"
        yield Finding("warning", what, figure, "sample faster or move slower")
    if shown.one_way:
        figure = f"{shown.reversals} reversals, and it slides in one direction only"
        advice = f"move it both ways, {PLAN} F_c"
        yield Finding("warning", ONE_WAY, figure, advice, spoils="values", hides=("F_c", "F_s"))
    elif shown.reversals < log_content.REVERSALS:
        figure = f"{shown.reversals} reversals"
        yield Finding("warning", "F_c and the offset are hard to separate", figure, f"{PLAN} F_c")
    if np.isfinite(shown.inertial):
        share = f"{shown.inertial:.1%} of the force"
        figure = f"accelerations up to {shown.acceleration:.3g} {unit}/s^2 cause {share}"
        words = "m is identifiable", "m is poorly identifiable"
        yield Finding.either(shown.inertial >= log_content.INERTIAL, words, figure, f"{PLAN} m")
    if high < log_content.SPEEDS * low:
        figure = f"only speeds of {speeds}"
        yield Finding("warning", "b and F_c are hard to separate", figure, f"{PLAN} b F_c")
    share = f"{shown.slow:.1%} of the motion, {shown.slow_samples} samples"
    figure = f"{share} below {quantity(shown.slow_speed, f'{unit}/s')}"
    words = "F_s and v_s may be identifiable", "F_s and v_s are poorly identifiable"
    yield Finding.either(shown.slow >= log_content.SLOW, words, figure, f"{PLAN} F_s v_s")
    turn, advice = shown.turn_around, f"{PLAN} sigma_0 sigma_1"
    if turn is None:
        what = "sigma_0 and sigma_1 are not identifiable"
        yield Finding("warning", what, "no velocity reversal was found", advice)
        return
    counts = f", {turn.counts:.0f} encoder steps" if np.isfinite(turn.counts) else ""
    figure = (
        f"{turn.times} velocity reversals; friction reverses within"
        f" {quantity(turn.distance, unit)}{counts} and {turn.samples:.0f} samples"
    )
    fine = turn.times * turn.samples >= log_content.TURNS
    fine &= min(turn.counts, turn.samples) >= log_content.TURN
    words = "sigma_0 and sigma_1 may be identifiable", "sigma_0 and sigma_1 are poorly identifiable"
    yield Finding.either(fine, words, figure, advice)
