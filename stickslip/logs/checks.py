"""Faults of a recording, and what it can show."""

from collections.abc import Iterator

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.fmi.messages import quantity, scaled_unit
from stickslip.logs.description import Controller
from stickslip.logs.excitation import Excitation, excitation
from stickslip.logs.force_path import force_path
from stickslip.logs.grid import runs
from stickslip.logs.motion import Delay, aligned, force_delay, kinematics, signal_delay, sure_delay
from stickslip.logs.recording import Finding, Recording, Severity
from stickslip.logs.sampling import step_of
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import log_content, log_force

WINDOW = 7  # number of differences of the position in the moving median
ALIKE = 0.25  # largest deviation of the neighbours of a jump from that median, relative
STEPS = 5.0  # encoder steps per row from which one row can be distinguished from two


def lost_rows(recording: Recording) -> Finding | None:
    """Return a finding where single steps of the position are whole multiples of their neighbours.

    A mass cannot move twice as far in one sample as in those before and after; a row is missing
    there, though the clock is even.
    """
    x = recording.position
    if x is None or len(x) < 10 * WINDOW:
        return None
    steps = np.diff(x)
    usual = scipy.ndimage.median_filter(steps, WINDOW)
    noise = 1.4826 * float(np.median(np.abs(np.diff(x, 3)))) / np.sqrt(20.0)
    fast = np.abs(usual) > max(STEPS * recording.encoder_step, 10.0 * noise)
    off = np.abs(steps - usual)
    beside = np.maximum(np.roll(off, 1), np.roll(off, -1))
    fast[[0, -1]] = False
    fast &= beside < ALIKE * np.abs(usual)
    ratio = steps[fast] / usual[fast]
    missing = np.round(ratio) - 1.0
    found = (missing >= 1.0) & (np.abs(ratio - np.round(ratio)) < 0.3 * missing)
    if np.sum(found) < log_force.LOST_ROWS:
        return None
    share = float(np.sum(missing[found]) / (len(ratio) + np.sum(missing[found])))
    figure = f"{share:.2%}, the position jumps {np.sum(found)} times by a multiple of its step"
    advice = "log without gaps, or with the true times"
    return Finding("warning", "rows are lost under an even clock", figure, advice, spoils="values")


def saturation(recording: Recording, limit: float | None) -> Iterator[Finding]:
    """Yield forces at a limit, and such that are beyond the one that is stated [N].

    A force that stays at its extreme may be one that was commanded, or Coulomb friction of a drive
    at constant speed. It is limited only where the force command is larger, or where the error of
    the motion grows, by so much that the loop would command more.
    """
    unit = "N m" if recording.rotary else "N"
    for name in ("force", "force_command"):
        force = getattr(recording, name)
        if force is None:
            continue
        most = float(np.max(np.abs(force)))
        exceeds = limit is not None and most > log_force.EXCEEDED * limit
        # the limit may be lower than stated; one that is exceeded limits nothing
        for at in (None,) if exceeds else dict.fromkeys((limit, None)):
            marked = _held_back(recording, name, force, at)
            if (share := float(np.mean(marked))) > (0.0 if at else log_force.SELDOM):
                advice = "there it does not follow its command; log a gentler motion"
                what = f"{name} saturates at {float(np.max(np.abs(force[marked]))):.4g} {unit}"
                yield Finding("warning", what, f"{share:.2%}", advice, spoils="intervals")
                break
        if exceeds:
            figure = f"{most:.4g} against {limit:.4g} {unit}"
            advice = "check unit and scale, and that it was logged behind the limit"
            what = f"{name} exceeds the force limit"
            yield Finding("warning", what, figure, advice, spoils="values")


def _held_back(
    recording: Recording, name: str, force: Array, limit: float | None
) -> NDArray[np.bool_]:
    """Return where (n,) a force is at a limit [N], or at its extreme, and more is due."""
    marked, step = np.zeros(len(force), dtype=bool), step_of(force)
    for sign in (1.0, -1.0):
        one = sign * force
        most, few = float(np.quantile(one, 0.999)), round(log_force.PLATEAU)
        if not limit and np.partition(one, -few)[-few] > (1.0 + log_force.AT_LIMIT) * most:
            continue  # a peak, not an extreme at which the force stays
        level = log_force.AT_STATED * limit if limit else (1.0 - log_force.AT_LIMIT) * most
        if level > 0.0:
            demand = _demand(recording, name, sign, one < level, level=level)
            least = log_force.DEMANDED * level + step
            for begin, end in runs(one >= level):
                part = slice(begin, end)
                more = _more(demand, part, level) > least if demand else bool(limit)
                marked[part] |= more and end - begin >= log_force.PLATEAU
    return marked


def _more(demand: tuple[Array, bool], samples: slice, level: float) -> float:
    """Return how much more [N] is asked for in some samples than the force there."""
    signal, changes = demand
    part = signal[samples]
    return float(np.max(part) - part[0] if changes else np.mean(part) - level)


def _demand(
    recording: Recording, name: str, sign: float, free: NDArray[np.bool_], level: float
) -> tuple[Array, bool] | None:
    """Return the force (n,) that is asked for in one direction [N], None if no command is known.

    Without a force command it is that of a velocity loop, or of a cascade where the position was
    commanded, whose gains the rest of the log shows. Only its changes are known then: the second
    value.
    """
    force = sign * getattr(recording, name)
    command = recording.force_command
    if name == "force" and command is not None:
        large = free & (np.abs(force) > 0.3 * level)
        ratio = float(np.median(sign * command[large] / force[large])) if large.any() else 1.0
        return np.asarray(sign * command / (ratio if ratio > 0.0 else 1.0)), False
    motion = kinematics(recording)
    if recording.velocity_command is not None:
        wanted, shown, more = recording.velocity_command, motion.v, []
    elif recording.position_command is not None:
        wanted, shown, more = recording.position_command, motion.x, [motion.v]
    else:
        return None
    error = smoothed(wanted, recording.T_s, motion.cutoff) - shown
    terms = sign * np.column_stack([error, *more])
    reach = max(1, round(0.5 / (motion.cutoff * recording.T_s)))
    smooth = smoothed(force, recording.T_s, motion.cutoff)
    used = free[reach:] & free[:-reach]
    changes = terms[reach:] - terms[:-reach]
    rise = (smooth[reach:] - smooth[:-reach])[used]
    gains = np.linalg.lstsq(changes[used], rise, rcond=None)[0]
    if gains[0] <= 0.0 or np.any(gains[1:] > 0.0):  # those of no loop
        return np.zeros_like(force), True
    return np.asarray(terms @ gains), True


PLAN = "stickslip plan --show"
REMOVED = "are removed before learning"
ONE_WAY = "F_c and the constant force cannot be told apart"


def check_recording(
    recording: Recording,
    controller: Controller | None = None,
    force_limit: float | None = None,
    *,
    alone: bool = True,
) -> tuple[Finding, ...]:
    """Return the findings on a recording made with a controller under a force limit [N].

    Of one of several logs, which is not ``alone``, they do not tell what it shows of the drive.
    """
    controller = controller or Controller()
    findings = [*_signals(recording, controller)]
    if any(finding.severity == "error" for finding in findings):
        return tuple(findings)
    shown, lost, delay = excitation(recording), lost_rows(recording), force_delay(recording)
    sure = sure_delay(recording, delay)
    late = 0 if sure is None or sure.at_bound else round(sure.value / recording.T_s)
    prompt = aligned(recording, late)
    return (
        *findings,
        *([lost] if lost else force_path(prompt, force_delay(prompt) if late else delay)),
        *saturation(recording, force_limit),
        *_quantisation(recording, shown),
        *_delays(recording, sure, delay, late),
        *((*_duration(recording), *_visibility(recording, shown)) if alone else ()),
    )


def _signals(recording: Recording, controller: Controller) -> Iterator[Finding]:
    """Yield what is missing, not finite, constant or short."""
    for name, signal in recording.arrays.items():
        if name == "t":
            continue
        if len(signal) != len(recording.t):
            figure = f"{len(signal)} values, expected {len(recording.t)}"
            yield Finding("error", f"{name} is not as long as the time", figure)
        elif not np.isfinite(signal).all():
            where = f"the first at {recording.t[np.argmin(np.isfinite(signal))]:.6g} s"
            yield Finding("error", f"{name} holds values that are not finite", where)
        elif np.ptp(signal) == 0 and (signal[0] or not name.startswith("added_")):
            severity: Severity = (
                "error" if name in ("position", "velocity", "force", "friction") else "warning"
            )
            figure = f"{signal[0]:.6g} throughout"
            yield Finding(severity, f"{name} never changes", figure, "log another column")
    if recording.position is None and recording.velocity is None:
        yield Finding("error", "neither position nor velocity", advice="log one")
    if recording.force is None and recording.friction is None:
        if recording.force_command is None and controller.kind == "none":
            advice = "log the motor's current, or give <controller>"
            yield Finding("error", "neither force nor friction", advice=advice)
        elif recording.force_command is None:
            what = "no force was logged; all forces follow from the gains that were given"
            advice = "log the motor's current; friction and mass are as wrong as the gains"
            yield Finding("warning", what, advice=advice, spoils="intervals")
        else:
            what = "no force was measured, only commanded"
            yield Finding("note", what, advice="the amplifier is taken to follow")
    if controller.needs and getattr(recording, controller.needs) is None:
        what = f"a {controller.kind} controller, but no {controller.needs}"
        sent = "; the command that was sent has it, as the table of 'stickslip plan'"
        advice = f"give <column {controller.needs}=NAME>"
        yield Finding("error", what, advice=advice + sent * ("position" in controller.needs))


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


def _delays(
    recording: Recording, sure: Delay | None, delay: Delay | None, late: int
) -> Iterator[Finding]:
    """Yield delays of signals relative to each other; that of the force may be sure."""
    if sure and sure.at_bound:
        figure = f"{1e3 * sure.value:.4g} ms, the largest that is looked for, explains most of it"
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
        advice = f"{1e3 * taken_out * T_s:.4g} ms {REMOVED}"
        return Finding("warning", f"{name} is {way} relative to {other}", figure, advice)
    if not delay.known(T_s):
        return Finding("note", f"the delay of {name} relative to {other} is not determined", figure)
    return Finding("note", f"{name} is {way} relative to {other}", figure)


def visibility(recording: Recording) -> tuple[Finding, ...]:
    """Return what several logs show of the drive together."""
    return (*_duration(recording), *_visibility(recording, excitation(recording)))


def _duration(recording: Recording) -> Iterator[Finding]:
    duration = float(recording.t[-1])
    if duration < log_content.DURATION or len(recording.t) < log_content.SAMPLES:
        figure = f"{duration:.3g} s, {len(recording.t)} samples"
        yield Finding("warning", "the recording is short", figure, "log 10 s or more")


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
        what, advice = "reversals are too fast for the sample rate", "sample faster or move slower"
        hides = ("m",) if shown.inertial < log_content.INERTIAL else ()  # friction passes for it
        yield Finding("warning", what, figure, advice, spoils="intervals", hides=hides)
    if shown.one_way:
        figure = f"{shown.reversals} reversals, and it moves in one direction only"
        advice = f"move it both ways, {PLAN} F_c"
        yield Finding("warning", ONE_WAY, figure, advice, spoils="values", hides=("F_c", "F_s"))
    elif shown.reversals < log_content.REVERSALS:
        figure = f"{shown.reversals} reversals"
        yield Finding("warning", "F_c and the offset are hard to separate", figure, f"{PLAN} F_c")
    if np.isfinite(shown.inertial):
        share = f"{shown.inertial:.1%} of the force"
        figure = f"accelerations up to {shown.acceleration:.3g} {unit}/s^2 cause {share}"
        words = "m may be identifiable", "m is poorly identifiable"
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
        f"friction turns at {turn.times} reversals, within {quantity(turn.distance, unit)}{counts}"
        f" and {turn.samples:.0f} samples"
    )
    fine = turn.times * turn.samples >= log_content.TURNS
    fine &= min(turn.counts, turn.samples) >= log_content.TURN
    words = "sigma_0 and sigma_1 may be identifiable", "sigma_0 and sigma_1 are poorly identifiable"
    yield Finding.either(fine, words, figure, advice)
