"""Whether the given controller commands the force that was logged."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.identification.criteria.known_loop import NO_LIMIT, initial_state, memory_force
from stickslip.identification.criteria.motion import (
    against_motion,
    differences,
    position_of,
    recording_scale,
    white_noise,
)
from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.logs import Finding, Reading, Recording, aligned, samples_late
from stickslip.logs.checks import REMOVED
from stickslip.logs.plausibility import DIFFER
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import control_match, log_delay

OWN = ""  # name of the form that the FMU has
_INTEGRALS = {"": 0.0, "integral by the trapezoidal rule": 0.5, "integral by forward Euler": 1.0}
"""Share of the last sample's error that the integral in use lacks."""
_FILTERS = ("", "low-pass by backward Euler", "low-pass by forward Euler")


def forms(gains: Mapping[str, float], T_s: float) -> dict[str, dict[str, float]]:
    """Return gains of the FMU for each form that a controller may have, by display name.

    The FMU adds an error to its integral before it uses that, and its low-pass is exact for a held
    input. Controllers that use the integral first, or the mean of both, are the same with less
    proportional gain; those whose low-pass is a difference quotient, with another time constant.

    The gains are in any units that agree. T_s is the sample period of the log [s], used where the
    gains have none.
    """
    T_s = gains.get("T_s", T_s)
    found: dict[str, dict[str, float]] = {}
    for integral, lacking in _INTEGRALS.items():
        for low_pass in _FILTERS:
            form = {
                **gains,
                "K_p": gains.get("K_p", 0.0) - lacking * T_s * gains.get("K_i", 0.0),
                "P_x": gains.get("P_x", 0.0) - lacking * T_s * gains.get("I_x", 0.0),
                "tau_f": _time_constant(low_pass, gains.get("tau_f", 0.0), T_s),
            }
            if min(form["K_p"], form["P_x"]) >= 0.0 and form not in found.values():
                found[", ".join(filter(None, (integral, low_pass)))] = form
    return found


COMMANDS = {
    "position command half a sample later than the log's": 0.5,
    "position command half a sample earlier than the log's": -0.5,
}
"""Samples by which the sum of a velocity command lags its integral, if added up after its use."""


def _time_constant(low_pass: str, tau_f: float, T_s: float) -> float:
    """Return tau_f [s] of the exact low-pass that weighs its input as a difference quotient does.

    The FMU weighs it by 1 - e^(-T_s / tau_f), backward Euler by T_s / (T_s + tau_f), forward Euler
    by T_s / tau_f.
    """
    if "backward" in low_pass and tau_f > 0.0:
        return T_s / math.log1p(T_s / tau_f)
    if "forward" in low_pass and tau_f > T_s:
        return -T_s / math.log1p(-T_s / tau_f)
    return tau_f


SHARE = 1.0 / 50.0  # cut-off of the low-pass over the sample rate: noise is no disagreement
SHIFTS = range(5)  # samples by which the logged force may be older than the command
USUAL = 0.99  # share of the samples that are not where one log ends and another begins
LIMITED = "limit of the force as the log shows it"
LEVELS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 1.0)
"""Quantiles of the force that are tried as its limit."""


@dataclass(frozen=True)
class ControllerCheck:
    """What the controller FMU commands along the recorded motion."""

    force: Array  # (n,) that it commands, each value held from its sample on [N]
    # root mean square of logged without commanded force, relative to how the logged one varies, all
    # low-passed; NaN where no force was logged
    error: float
    shift: int  # samples by which the log shows a command late
    # of the FMU, in the form that commands the logged force best, with what its memory held if it
    # was running before the log began
    gains: Mapping[str, float]
    form: str = OWN  # how that differs from the FMU's own; empty if it does not
    factor: float = 1.0  # of the logged force over the commanded one, where only it differs; else 1
    source: str = ""  # the log of that factor, if there are several

    @property
    def difference(self) -> str:
        """The error in per cent, without an exponent."""
        return f"{float(f'{100.0 * self.error:.2g}'):g} %"


def check_controllers(
    fmus: Path, recording: Recording, gains: Mapping[str, float]
) -> tuple[Recording, ControllerCheck]:
    """Check the controller of each log, and return the recording with the gains as they are found.

    The check of several logs is that of the first, with the force and the error of all: noise is
    much of a log that hardly varies.
    """
    if not recording.segments:
        return recording, check_controller(fmus, recording, gains)
    checks = [
        check_controller(fmus, recording.log(one), one.gains or gains) for one in recording.segments
    ]
    pairs = list(zip(recording.segments, checks, strict=True))
    force = np.zeros_like(recording.t) if recording.force is None else recording.force.copy()
    for one, check in pairs:
        force[one.begin : one.end] = check.force
    segments = tuple(replace(one, gains=check.gains) for one, check in pairs)
    error = float("nan")
    if recording.force is not None:
        parts = [recording.force[one.begin : one.end] for one in recording.segments]
        sizes = np.array([_slow(part - part.mean(), recording.T_s) for part in parts])
        errors = sizes * [check.error for check in checks]
        error = float(np.linalg.norm(errors) / (np.linalg.norm(sizes) or 1.0))
    one, worst = max(pairs, key=lambda pair: abs(math.log(abs(pair[1].factor) or 1e-300)))
    together = replace(
        checks[0], force=force, error=error, factor=worst.factor, source=f"{one.source}: "
    )
    return replace(recording, segments=segments), together


def with_force(recording: Recording, gains: Mapping[str, float] | None) -> Recording:
    """Return a recording in which the controller's command stands for a force not logged."""
    known = recording.force, recording.friction, recording.force_command
    if gains is None or any(one is not None for one in known):
        return recording
    with candidate_fmus() as fmus:
        checked, check = check_controllers(fmus, recording, gains)
    return replace(checked, force=check.force)


def check_controller(
    fmus: Path, recording: Recording, gains: Mapping[str, float]
) -> ControllerCheck:
    """Run the controller FMU along the recorded motion and commands, in each of its forms."""
    system = cosim.System("controller")
    system.add(
        "controller",
        fmus / "velocity_controller.fmu",
        {"u_max": NO_LIMIT, "T_s": recording.T_s, **gains},
    )
    inputs = {"x_enc": position_of(recording), **recording.controller_inputs}
    for name in inputs:
        system.expose(name, f"controller.{name}")
    stop = (len(recording.t) - 1) * recording.T_s
    with system.prepare(step=recording.T_s, stop=stop, record=["controller.u"]) as simulation:

        def commanded(gains: Mapping[str, float]) -> Array:
            parameters = {f"controller.{name}": value for name, value in gains.items()}
            shown = simulation.run(parameters, inputs)["controller.u"]
            return np.append(shown[1:], shown[-1])  # row n + 1 shows what sample n decided

        if recording.force is None:
            return ControllerCheck(commanded(gains), float("nan"), 0, gains)
        force, T_s = recording.force, recording.T_s

        def compared(gains: Mapping[str, float], form: str) -> ControllerCheck:
            return _compared(force, T_s, commanded(gains), gains, form=form)

        trials = forms(gains, T_s)
        checks = [compared(trial, form) for form, trial in trials.items()]
        check = _believed(checks[0], min(checks, key=lambda check: check.error))
        if check.error > control_match.EXACT and gains.get("K_x"):
            late, own = [check], trials[check.form]
            for form, samples in COMMANDS.items():
                # Of the command x the part T v is the same as less feedforward of the velocity v.
                lead = samples * own.get("T_s", T_s) * own["K_x"]
                share = own.get("velocity_feedforward", 1.0) - lead
                if share >= 0.0:
                    named = ", ".join(filter(None, (check.form, form)))
                    late.append(compared({**own, "velocity_feedforward": share}, named))
            check = _believed(check, min(late, key=lambda one: one.error))
        if check.error > control_match.EXACT and "u_max" not in gains and check.form in trials:
            form = ", ".join(filter(None, (check.form, LIMITED)))
            limits = np.quantile(np.abs(force), LEVELS)
            limited = [compared({**trials[check.form], "u_max": at}, form) for at in limits]
            best = min(limited, key=lambda check: check.error)
            check = best if best.error <= control_match.EXACT else check
    return replace(check, factor=_factor(force, T_s, check))


def force_noise(force: Array | None, check: ControllerCheck | None) -> float:
    """Return the standard deviation of a logged force (n,) about the one commanded [N].

    The log may show a mean of commands beside each other, as where the current lags. It is 0 where
    the controller is not known: its gains make noise as well.
    """
    if force is None or check is None or not check.error <= control_match.EXACT:
        return 0.0
    known = slice(check.shift + 1, -2)  # without what rolls round, and the last one that is held
    beside = np.column_stack([np.roll(check.force, check.shift + k)[known] for k in (-1, 0, 1)])
    fast, shown = differences(beside), differences(force[known])
    usual = (np.abs(fast) <= np.quantile(np.abs(fast), USUAL, axis=0)).all(axis=1)
    weights = np.linalg.lstsq(fast[usual], shown[usual], rcond=None)[0]
    return white_noise(force[known] - beside @ weights)


def check_reading(reading: Reading) -> ControllerCheck | None:
    """Check the controller of a log as it is described; None where gains or force are not known."""
    gains, recording = reading.controller.parameters(), reading.recording
    if gains is None or recording.force is None:
        return None
    scale = recording_scale(recording)
    scaled, _ = against_motion(scale.recording(recording))
    with candidate_fmus() as fmus:
        return check_controllers(fmus, scaled, scale.values(gains))[1]


def in_time(reading: Reading, findings: Iterable[Finding]) -> tuple[Reading, tuple[Finding, ...]]:
    """Return a log with its force in time with the motion, and findings on it.

    Where the controller commands the force as it was logged, that is not late, nor are commands of
    another scale: a contact that bends far before it slides looks so.
    """
    found = tuple(findings)
    late, doubts = samples_late(reading.recording), [one for one in found if _is_doubt(one)]
    check = check_reading(reading) if late or doubts else None
    if check and check.error <= control_match.EXACT and check.shift < log_delay.REPORTED:
        return reading, tuple(one for one in found if one not in doubts)
    return replace(reading, recording=aligned(reading.recording, late)), found


def _is_doubt(one: Finding) -> bool:
    """Tell whether a finding is about the time of the force or the scale of a command."""
    return one.advice.endswith(REMOVED) or ("command" in one.what and one.what.endswith(DIFFER))


def _factor(force: Array, T_s: float, check: ControllerCheck) -> float:
    """Return the factor by which the logged force differs from the commanded one, else 1."""
    n = len(force) - check.shift
    late, commanded = (
        smoothed(signal - signal.mean(), T_s, SHARE / T_s)
        for signal in (force[check.shift :], check.force[:n])
    )
    factor = float(late @ commanded) / (float(commanded @ commanded) or 1.0)
    rest = np.linalg.norm(late - factor * commanded) / (np.linalg.norm(late) or 1.0)
    return factor if rest < control_match.OUT_OF_SCALE * min(1.0, check.error) else 1.0


def _believed(own: ControllerCheck, other: ControllerCheck) -> ControllerCheck:
    return other if other.error < control_match.OTHER_FORM * own.error else own


def _compared(
    force: Array, T_s: float, commanded: Array, gains: Mapping[str, float], form: str
) -> ControllerCheck:
    """Compare with a controller that begins with the log, and with one that was running before."""

    def best(*, running: bool) -> ControllerCheck:
        checks = []
        for shift in SHIFTS:
            late = force[shift : shift + len(force) - max(SHIFTS)]
            missing = late - commanded[: len(late)]
            started = {**gains, **(initial_state(missing, gains, T_s) if running else {})}
            rest = missing - memory_force(started, len(late), T_s)
            error = _slow(rest, T_s) / (_slow(late - late.mean(), T_s) or 1.0)
            shown = commanded + memory_force(started, len(commanded), T_s)
            checks.append(ControllerCheck(shown, error, shift, started, form=form))
        return min(checks, key=lambda check: check.error)

    return _believed(best(running=False), best(running=True))


def _slow(signal: Array, T_s: float) -> float:
    return float(np.linalg.norm(smoothed(signal, T_s, SHARE / T_s)))
