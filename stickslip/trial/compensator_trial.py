"""A learned compensator is tried on simulated drives before it is written."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.signal import lfilter
from scipy.stats import qmc

from stickslip.catalog.parameters import ParameterSpace, friction_law, presliding
from stickslip.cosim import Trapezoid
from stickslip.evaluation.motions import VALIDATION
from stickslip.identification.criteria.controller_check import force_noise
from stickslip.identification.criteria.motion import encoder_noise, position_of
from stickslip.identification.estimation import Estimation, LearnSettings
from stickslip.identification.fitting.identifiability import IDENTIFIABLE, bounded_by
from stickslip.logs import Reading, Recording
from stickslip.models import Law
from stickslip.servo.axis import LOOP, Axis, ControlError, Datasheet, LoopSpecification
from stickslip.servo.measurement import Array, smoothed
from stickslip.servo.observer import masses_between
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop, design_velocity_loop
from stickslip.thresholds import control_match, harm
from stickslip.trial.benefit import NONE, RISING, Benefit, Variant, bench_of, best_of, feedforward
from stickslip.trial.candidates import CompensatorComparison, compare
from stickslip.trial.family import Command, Drive, Evidence, deflections, family, hidden_deflections
from stickslip.trial.hold import Hold, holds, hunting_at_rest


class Loops(NamedTuple):
    """Velocity loops of a drive."""

    plain: VelocityLoop  # without compensation
    compensated: VelocityLoop  # in which the compensator runs
    foreign: str = ""  # whose they are, and why not the drive's; empty where they are

    @property
    def known(self) -> bool:
        """Whether the drive runs in them, and not only the trial."""
        return not self.foreign


@dataclass(frozen=True)
class SimulatedTrial:
    """What trying a compensator on simulated drives gave."""

    command: Trapezoid
    datasheet: Datasheet
    benefit: Benefit  # with feedforward of the law, at the share of its force that passes
    compared: CompensatorComparison  # all compensators that were tried
    warnings: tuple[str, ...]  # where a cascade does not come to rest, a line each
    drives: tuple[Drive, ...] = ()  # on which it was tried
    others: tuple[Benefit, ...] = ()  # the same as ``benefit`` for other ways to compensate
    holds: Mapping[str, Hold] = field(default_factory=dict)  # of a cascade, by way to compensate
    own: tuple[Command, ...] = ()  # motions of the user that it was tried on alone

    def table(self) -> pd.DataFrame:
        """Return a row for each way to compensate, drive and command.

        Speeds and errors are in m/s, of the figure ``position`` in m; rad for a rotary drive.
        """
        rows = [
            {
                "compensation": benefit.variant.name,
                "share": benefit.share,
                "drive": row.drive,
                "command": row.command,
                "figure": row.figure,
                "speed": row.speed,
                "friction": row.level,
                "without": row.without,
                "with": row.compensated,
                "ratio": row.ratio,
            }
            for benefit in (self.benefit, *self.others)
            for row in (*benefit.rows, *benefit.beyond, *benefit.swept)
        ]
        return pd.DataFrame(rows)


SHOWN = (1e-3, 0.1)
"""Speeds between which a Stribeck velocity may lie that is not known, over the log's speed."""
CAUTIOUS = (0.4, 60.0)
"""Bandwidth, over that of the paper's loop, and phase margin [degrees] of a velocity loop whose
command and force do not show its gains: feedforward harms most in a slow loop."""
SLOW = 50.0
"""Cut-off [Hz] behind which velocity error and force show the controller's gains, or a part of the
sampling rate."""


def datasheet_of(reading: Reading, estimation: Estimation, top: float, tau_i: float) -> Datasheet:
    """Return what is known of the motor of a log with a top speed [m/s]."""
    recording, force = reading.recording, estimation.figures.measured
    step = recording.encoder_step or 1e-6 * top
    return Datasheet(
        peak_force=reading.force_limit or harm.LIMIT * float(np.max(np.abs(force))),
        tau_i=tau_i,
        encoder_step=step,
        encoder_noise=encoder_noise(position_of(recording), step),
        force_noise=force_noise(estimation.recording.force, estimation.controller),
    )


def try_compensator(
    reading: Reading,
    estimation: Estimation,
    loop: VelocityLoop,
    settings: LearnSettings,
    *,
    own: tuple[Command, ...] = (),
) -> SimulatedTrial:
    """Try what may compensate at the log's own speed, or what the settings name.

    Own motions are the only ones on which it is tried.
    """
    top = float(np.quantile(np.abs(estimation.figures.velocity_recorded), 0.99))
    command = trapezoid_of(estimation.figures.velocity_recorded, top, estimation.recording.T_s)
    sheet = datasheet_of(reading, estimation, top, loop.axis.tau_i)
    step = sheet.encoder_step
    law, friction = estimation.law, estimation.compensator
    known = known_friction(estimation, top, settings.friction_range)
    drives = family(law, friction, command, known)
    rising = soft_rise(friction["F_c"], drives, command, step)
    workers = settings.workers
    with bench_of(
        *(law, loop, friction, drives), command=command, datasheet=sheet, own=own, workers=workers
    ) as bench:
        benefits = bench.benefits(feedforwards(law, friction))
        best = best_of(benefits)
        mass, m = estimation.known["m"], loop.axis.m
        masses = masses_between(mass.low / m, mass.high / m)
        compared = compare(
            bench,
            best,
            friction,
            masses,
            rivals=(*of_rivals(estimation, known), *([] if law.name == RISING else [rising])),
            asked=settings.compensator,
            absent=settings.absent,
        )
        tried = {row.name: row.benefit for row in compared.rows if row.benefit}
        held: dict[str, Hold] = {}
        warnings: list[str] = []
        if loop.K_x and (written := compared.chosen.benefit):
            variant = replace(written.variant, name=compared.chosen.name)
            variant = variant.share(law, written.share)
            held = holds(bench, [NONE, variant])
            warnings = hunting_at_rest(held, variant, sheet.encoder_step)
    others = tuple(one for one in (*benefits, *tried.values()) if one is not best)
    return SimulatedTrial(
        *(command, sheet, best, compared, tuple(warnings)),
        drives=drives,
        others=others,
        holds=held,
        own=own,
    )


DAMPED = 0.5  # damping ratio of a mass on bristles that a log does not show
RAMPS = (0.02, VALIDATION.height / VALIDATION.slope)
"""Least and largest time of a ramp to a log's speed [s]: what the low-pass of accelerations shows
(decision 170), and that of the paper."""


def trapezoid_of(v: Array, top: float, T_s: float) -> Trapezoid:
    """Return a trapezoid at the speed ``top`` [m/s] of a log, with about its accelerations.

    It is shorter than the paper's where the log's velocities (n,) [m/s] are quicker.
    """
    steps = np.abs(np.diff(smoothed(v, T_s, min(SLOW, 0.05 / T_s))))
    ramp = min(max(top * T_s / max(float(np.quantile(steps, 0.95)), 1e-300), RAMPS[0]), RAMPS[1])
    plateau = max(ramp / RAMPS[1], 0.5) * VALIDATION.plateau
    return replace(VALIDATION, height=top, slope=top / ramp, plateau=plateau)


def of_rivals(estimation: Estimation, known: Evidence) -> tuple[Variant, ...]:
    """Return feedforward of the other laws that explain a log.

    What it does not show of the rise towards rest is left out.
    """
    fitted = {one.candidate.law.name: one for one in estimation.held_out.predictions}
    found = []
    for name, (values, *_) in known.draws.items():
        if name not in fitted or name == estimation.law.name:
            continue
        law = fitted[name].candidate.law
        own = {one: value for one, value in values.items() if one in law.parameters}
        bounded = ParameterSpace.of(law).bounded.items()
        own |= {one: own[bound] for one, bound in bounded if one not in fitted[name].shown}
        file = f"compensator_{name}"
        one = Compensator("compensator", "compensator", own, file, law=name)
        found.append(Variant(name, (one,)))
    return tuple(found)


def soft_rise(F_c: float, drives: Sequence[Drive], command: Trapezoid, step: float) -> Variant:
    """Return feedforward of Coulomb friction that rises over the longest presliding deflection.

    In moves in which a drive may stick it has little force, so that it lets none jump.
    """
    longest = max(max(every) for every in deflections(drives, command, step).values())
    values = {"F_c": F_c, "sigma_0": F_c / longest}
    one = Compensator("compensator", "compensator", values, f"compensator_{RISING}", law=RISING)
    return Variant(f"soft_{RISING}", (one,))


def feedforwards(law: Law, friction: Mapping[str, float]) -> tuple[Variant, ...]:
    """Return what may be written: feedforward of the friction, and of its level alone."""
    bounded = ParameterSpace.of(law).bounded
    level = {**friction, **{name: friction[bound] for name, bound in bounded.items()}}
    names = ", ".join(f"{name} = {bound}" for name, bound in bounded.items())
    whole = feedforward(friction)
    return (whole,) if level == friction else (whole, feedforward(level, f"feedforward, {names}"))


def known_friction(estimation: Estimation, top: float, levels: tuple[float, float]) -> Evidence:
    """Return what a log tells of friction besides the estimate, for ``family``.

    Its highest speed is ``top`` [m/s]. Static friction is bounded by the largest friction in the
    log, with a reserve. Other laws are those that predict the force where they were not fitted
    about as well as the best one does, or as well as noise and steps allow; of those without
    presliding, one.
    """
    space, known, law = estimation.fit.space, estimation.known, estimation.law
    taken = (known[name].value for name in space.bounded)
    largest = harm.RESERVE * max(estimation.largest_friction, *taken, 0.0)
    fitted, ranges = {**estimation.parameters, **next(iter(estimation.plausible), {})}, {}
    for name in (one for one in space.friction if known[one].identifiability != IDENTIFIABLE):
        low, high = known[name].low, known[name].high
        if law.parameters[name].unit == "m/s":
            least, most = (share * top for share in SHOWN)
            low, high = (min(max(end, least), most) for end in (low, high))
        else:
            low, high = max(low, fitted[name] / harm.WIDE), min(high, fitted[name] * harm.WIDE)
        limits = law.parameters[name]
        low, high = max(low, limits.low), min(high, limits.high)
        if name in space.bounded:
            high = min(known[name].high, largest)
        ranges[name] = (low, max(low, high))
    draws: dict[str, Sequence[Mapping[str, float]]] = {}
    draws[law.name] = _spread(estimation.plausible, ranges)
    found = estimation.held_out.predictions
    least = min((one.force for one in found), default=0.0)
    for tried in found:
        other = tried.candidate.law
        explains = tried.force <= harm.EXPLAINS * max(least, tried.explained)
        is_alike = not (presliding(other) or presliding(law))
        if explains and not (other.name in draws or tried.candidate.is_level or is_alike):
            draws[other.name] = tried.plausible
    step = estimation.recording.encoder_step or 0.0
    if step and not any(presliding(friction_law(name)) for name in draws):
        draws["lugre"] = unseen(draws[law.name], step)
    spaces = {name: ParameterSpace.of(friction_law(name)) for name in draws}
    return Evidence(
        {
            name: [
                _of_drive(bounded_by(one, spaces[name], largest))
                for one in stiffer(exponents(friction_law(name), found), step)
            ]
            for name, found in draws.items()
        },
        levels,
    )


def stiffer(draws: Sequence[Mapping[str, float]], step: float) -> list[dict[str, float]]:
    """Return draws with stiffnesses up to several times that fitted, where few steps show it.

    Such a fit is too soft: the encoder rounds what it shows of the deflection.
    """
    found = []
    for one, share in zip(draws, np.linspace(0.0, 1.0, len(draws)), strict=True):
        values = dict(one)
        if "sigma_0" in one and one["F_c"] < harm.COARSE * step * one["sigma_0"]:
            most = max(one["F_c"] / (harm.HIDDEN * step), one["sigma_0"])
            values["sigma_0"] = min(one["sigma_0"] * harm.STIFFER**share, most)
        found.append(values)
    return found


def exponents(law: Law, draws: Sequence[Mapping[str, float]]) -> list[Mapping[str, float]]:
    """Return draws of which every second one has another value of what has choices.

    A log rarely tells the exponent of the Stribeck curve, on which sticking in creep depends.
    """
    others = {
        name: dict(zip(p.choices, reversed(p.choices), strict=True))
        for name, p in law.parameters.items()
        if p.choices
    }

    def other(values: Mapping[str, float]) -> Mapping[str, float]:
        return {k: others[k].get(x, x) if k in others else x for k, x in values.items()}

    return [other(one) if k % 2 else one for k, one in enumerate(draws)]


def unseen(draws: Sequence[Mapping[str, float]], step: float) -> list[dict[str, float]]:
    """Return draws of a law without presliding, with as much as steps of an encoder [m] hide."""
    found = []
    for values, bends in zip(draws, hidden_deflections(step, len(draws)), strict=True):
        sigma_0 = values["F_c"] / bends
        sigma_1 = 2.0 * DAMPED * np.sqrt(sigma_0 * values["m"])
        found.append({**values, "sigma_0": sigma_0, "sigma_1": float(sigma_1)})
    return found


def _spread(
    draws: Sequence[Mapping[str, float]], ranges: Mapping[str, tuple[float, float]]
) -> list[Mapping[str, float]]:
    """Return draws, after the first, with values spread evenly over ranges of what is not known."""
    points = qmc.Sobol(max(len(ranges), 1), seed=0).random(len(draws))
    found = [*draws[:1]]
    for values, point in zip(draws[1:], points[1:], strict=False):
        drawn = {
            name: low * (high / low) ** share if low > 0.0 else low + share * (high - low)
            for share, (name, (low, high)) in zip(point, ranges.items(), strict=False)
        }
        found.append({**values, **drawn})
    return found


def _of_drive(values: Mapping[str, float]) -> dict[str, float]:
    """Return what a drive FMU takes of the values of an estimation."""
    kept = {name: value for name, value in values.items() if name not in ("F_0", "delay")}
    return {**kept, "b": max(kept["b"], 0.0)} if "b" in kept else kept


def loops_of_log(reading: Reading, estimation: Estimation) -> Loops:
    """Return the loop of the log's controller, the one that the log shows, or one like the paper's.

    A controller that does not command the logged force is not that of the drive. Where a velocity
    loop shows no gains, the one like the paper's is slower. Raises ControlError when the mass is
    not known, or no loop is stable.
    """
    known, controller = estimation.known, reading.controller
    if "m" not in known:
        raise ControlError("the mass is not known; learn from a log of position and motor force")
    for fault in estimation.faults:
        if "m" in fault.hides:
            raise ControlError(f"m is not known, as {fault.what}; {fault.advice}")
    rotary = reading.recording.rotary
    axis = Axis(known["m"].value, max(known["b"].value, 0.0), reading.tau_i or 0.0, rotary)
    T_s = estimation.recording.T_s
    check = estimation.controller
    foreign = "its controller is not known; <controller> and <gain> give it"
    if controller.P_x or controller.I_x:
        foreign = "its controller has gains P_x or I_x of the position, which the trial has not"
    elif check is not None and check.error > control_match.EXACT:
        foreign = f"the described controller differs from the logged force by {check.difference}"
    elif controller.K_p:
        gains = {name: getattr(controller, name) for name in ("tau_f", "K_p", "K_i", "K_x")}
        share = controller.velocity_feedforward
        try:
            loop = close_velocity_loop(
                axis,
                controller.T_s or T_s,
                **gains,
                velocity_feedforward=1.0 if share is None else share,
            )
            return Loops(loop, loop)
        except ControlError as error:
            foreign = f"it cannot be closed around the learned drive: {error}"
    if shown := shown_gains(reading.recording.first):
        K_p, K_i = shown
        with suppress(ControlError):
            loop = close_velocity_loop(axis, T_s, T_s, K_p, K_i=K_i)
            return Loops(loop, loop, f"to which the log points: {foreign}")
    slower, margin = 1.0, LOOP.phase_margin
    if reading.recording.velocity_command is not None:
        slower, margin = CAUTIOUS
    bandwidth = slower * LOOP.bandwidth * LOOP.T_s / T_s
    loop = design_velocity_loop(axis, LoopSpecification(bandwidth, margin, T_s, T_s))
    return Loops(loop, loop, f"which is not the log's: {foreign}")


def shown_gains(recording: Recording) -> tuple[float, float] | None:
    """Return K_p and K_i of the PI controller that a recording looks like, None for no such one."""
    v_cmd, force, T_s = recording.velocity_command, recording.force, recording.T_s
    if v_cmd is None or force is None:
        return None
    x = position_of(recording)
    keep = np.exp(-1.0)  # the controller's low-pass of the velocity, of one sample period
    v = lfilter([1.0 - keep], [1.0, -keep], np.diff(x, prepend=x[0]) / T_s)
    error = v_cmd - v
    signals = (error, np.cumsum(error) * T_s, np.ones_like(error), force)
    *columns, output = (smoothed(one, T_s, min(SLOW, 0.05 / T_s)) for one in signals)
    regressors = np.column_stack(columns)
    gains, *_ = np.linalg.lstsq(regressors, output, rcond=None)
    rest = output - regressors @ gains
    K_p, K_i, *_ = gains.tolist()
    most = (1.0 - control_match.GAINS_SHOWN) * np.var(output)
    shown = K_p > 0.0 and K_i >= 0.0 and np.var(rest) < most
    return (K_p, K_i) if shown else None
