"""Stage 2: friction over velocity in both directions, and the break-away force."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from stickslip.catalog.parameters import UNKNOWN, Estimate, covariance, unseen
from stickslip.errors import IdentificationError
from stickslip.rigs.contract import Rig
from stickslip.servo.measurement import Array, measured_velocity, smoothed
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.thresholds import stage

SPEEDS = np.geomspace(0.25e-3, 40e-3, 12)  # [m/s]
FAST = 3e-3  # from this speed on the whole guide is travelled, below it the beginning [m/s]
GUIDE, BEGINNING = 0.100, 0.010  # [m]
BLOCK = 0.0025  # of the guide, over which the force is averaged [m]
SETTLE, LEAD = 2.0, 0.010  # before that, at most [s] and [m]
SLOW = 20.0  # frequency below which the fluctuation of a speed counts [Hz]


@dataclass(frozen=True)
class Sliding:
    """Friction at the n speeds that the loop holds."""

    speed: Array  # (n,) [m/s]
    forward: Array  # (n,) motor force forward [N]
    back: Array  # (n,) motor force backward [N]
    friction: Array  # (n,) half their difference [N]
    error: Array  # (n,) its standard error [N]
    along: Array  # (k,) friction in each block of the guide, relative to its mean
    fluctuation: float  # largest standard deviation of the velocity about its mean [m/s]


def measure_sliding(rig: Rig, loop: VelocityLoop) -> Sliding:
    """Drive at each of the speeds; friction is that of the mean of the guide.

    What depends on the position alone, such as the motor's force ripple, cancels between the
    directions. Friction varies along the guide in the same proportion at each speed; the fast runs,
    which travel all of it, show how, so that the slow ones need not go far.

    Where the stage sticks and slips the mean force is not that of the mean speed: no such run
    counts. Raises IdentificationError when too few speeds are held.
    """
    tried = [_forth_and_back(rig, loop, speed) for speed in SPEEDS]
    held = [run is not None for run in tried]
    if sum(held) < stage.SPEEDS_HELD:
        raise IdentificationError(
            f"constant velocity: the loop holds {sum(held)} of {len(held)} speeds from "
            f"{SPEEDS[0]:g} to {SPEEDS[-1]:g} m/s within {100.0 * stage.HELD:.0f} %, expected at "
            f"least {stage.SPEEDS_HELD:g}; check tau_i and encoder_step of the data sheet, or "
            "raise the bandwidth"
        )
    runs = [run for run in tried if run is not None]
    halves = [0.5 * (forces[0] - forces[1]) for forces, _ in runs]
    along = np.mean([f / f.mean() for f in halves if len(f) == round(GUIDE / BLOCK)], axis=0)
    level = [(forces / along[: forces.shape[1]]).mean(axis=1) for forces, _ in runs]
    rest = [half / along[: len(half)] for half in halves]
    return Sliding(
        speed=SPEEDS[held],
        forward=np.array([force[0] for force in level]),
        back=np.array([force[1] for force in level]),
        friction=np.array([f.mean() for f in rest]),
        error=np.array([f.std(ddof=1) / np.sqrt(len(f)) for f in rest]),
        along=along,
        fluctuation=float(np.mean([fluctuation for _, fluctuation in runs])),
    )


def _forth_and_back(rig: Rig, loop: VelocityLoop, speed: float) -> tuple[Array, float] | None:
    """Return the mean force (2, k) [N] in each block, forward and back, and the fluctuation [m/s].

    None where the loop does not hold the speed. The velocity does not fluctuate more than the motor
    force would make the mass alone do.
    """
    reach = GUIDE if speed >= FAST else BEGINNING
    settle, travel = min(SETTLE, LEAD / speed), reach / speed
    turn = settle, 3.0 * settle + travel  # from before the guide to behind it, and back [s]
    t = rig.samples(turn[1] + 2.0 * settle + travel)
    log = rig.follow(speed * np.where((t < turn[0]) | (t >= turn[1]), -1.0, 1.0), loop)
    block = np.floor(log.x_enc / BLOCK)
    forward = (t >= turn[0] + 0.5 * settle) & (t < turn[1])
    back = t >= turn[1] + 0.5 * settle
    n = round(reach / BLOCK)
    v = np.gradient(smoothed(log.x_enc, rig.T_s, SLOW), rig.T_s)
    parts = [[way & (block == k) for k in range(n)] for way in (forward, back)]
    for part in parts:
        if not (all(map(np.any, part)) and np.std(v[np.any(part, axis=0)]) < stage.HELD * speed):
            return None
    forces = [[log.F_m[samples].mean() for samples in part] for part in parts]
    free = np.cumsum(log.F_m) * rig.T_s / loop.axis.m
    return np.array(forces), float(np.std((free - smoothed(free, rig.T_s))[forward]))


CREEP = 0.2  # standard deviation of break-away from F_s: bristles that creep break away earlier
RAMP = 4.0  # duration of a break-away ramp [s]
HIGHER = 1.2  # each ramp ends this much higher, so that a stage that slides does not go far

_NORMAL, _WEIGHTS = np.polynomial.hermite_e.hermegauss(9)
_WEIGHTS /= _WEIGHTS.sum()


@dataclass(frozen=True)
class FrictionMap:
    """Result of stage 2."""

    # of F(v) = b v + F_c + (F_s - F_c) exp(-|v| / v_s) [N s/m, N, N, m/s]
    b: Estimate
    F_c: Estimate
    F_s: Estimate
    v_s: Estimate
    # standard deviation of the velocity about each constant speed, which encoder steps and noise
    # cause in the loop and the slowest points show [m/s]
    fluctuation: float
    # (n,) the points: speed with its sign [m/s], force as the mean of the guide and its standard
    # error [N]
    velocity: Array
    force: Array
    error: Array
    breakaway: tuple[float, float]  # force at which the stage broke away, forward and back [N]
    place: float  # friction where it broke away, relative to the mean of the guide
    ramp_rate: float  # of the force that led there, at most [N/s]; a faster ramp breaks away later
    warning: str = ""  # why v_s is not known, or empty

    def curve(self, v: Array) -> Array:
        """Return the fitted friction (n,) [N] at velocities (n,) [m/s]."""
        values = np.array([e.value for e in (self.b, self.F_c, self.F_s, self.v_s)])
        return np.sign(v) * _friction(np.abs(v), values, 0.0)


def measure_friction(rig: Rig, loop: VelocityLoop, coarse_F_c: float) -> FrictionMap:
    """Drive at constant velocities, break away from rest, and fit the Stribeck curve.

    Raises IdentificationError when the stage does not break away, or the loop holds too few speeds.
    The loop holds the velocity. The first ramp ends at the Coulomb friction of stage 1 [N].
    """
    sliding = measure_sliding(rig, loop)
    place = float(sliding.along[0])
    broke = [_break_away(rig, direction, coarse_F_c) for direction in (1.0, -1.0)]
    breakaway = (broke[0][0], broke[1][0])

    # Standstill is F_s. Between the directions an offset and an asymmetry cancel.
    still = np.mean(breakaway) / place
    speed = np.append(0.0, sliding.speed)
    mean = np.append(still, sliding.friction)
    scatter = np.append(CREEP * still, sliding.error)
    weight = 1.0 / np.maximum(scatter, 1e-3 * mean.max())

    def residual(p: Array) -> Array:
        return np.asarray((_friction(speed, _values(p), p[4]) - mean) * weight)

    low = max(float(mean[1:].min()), 1e-3 * float(mean.max()))
    rise = max(float(mean.max()) - low, 1e-3 * low)
    slowest, fastest = sliding.speed[[0, -1]]
    bounds = (
        [-np.inf, -np.inf, -np.inf, np.log(slowest / 100.0), 0.0],
        [np.inf, np.inf, np.inf, np.log(fastest / 2.0), sliding.fluctuation],
    )
    fits = [
        least_squares(
            residual,
            [0.0, np.log(low), np.log(rise), np.log(v_s), 0.5 * sliding.fluctuation],
            bounds=bounds,
            x_scale="jac",
        )
        for v_s in np.geomspace(slowest, fastest / 4.0, 4)
    ]
    fit = min(fits, key=lambda candidate: candidate.cost)
    values = _values(fit.x)
    slope = np.diag(np.concatenate([[1.0], np.exp(fit.x[1:4]), [1.0]]))
    slope[2, 1] = values[1]  # F_s is F_c and a rise
    spread = slope @ covariance(np.asarray(fit.jac), fit.fun) @ slope.T
    b, F_c, F_s, v_s = (
        Estimate(float(value), float(error))
        for value, error in zip(values, np.sqrt(np.diag(spread)[:4]), strict=True)
    )
    reason = ""
    if F_s.value - F_c.value < stage.RISE * F_c.value:
        reason = f"does not rise towards rest: F_s = {F_s.value:.4g} N and F_c = {F_c.value:.4g} N"
    elif fit.active_mask[3] or not 0.0 < v_s.standard_error < UNKNOWN * v_s.value:
        reason = f"shows no v_s at {slowest:.3g} to {fastest:.3g} m/s, which the loop holds"
    if reason:
        v_s = unseen(v_s.value)
        reason = f"friction {reason}, so v_s = {v_s.value:.3g} m/s is a start value"
    return FrictionMap(
        b,
        F_c,
        F_s,
        v_s,
        fluctuation=float(fit.x[4]),
        velocity=np.concatenate([-sliding.speed[::-1], sliding.speed]),
        force=np.concatenate([sliding.back[::-1], sliding.forward]),
        error=np.sqrt(2.0) * np.concatenate([sliding.error[::-1], sliding.error]),
        breakaway=breakaway,
        place=place,
        ramp_rate=max(rate for _, rate in broke),
        warning=reason,
    )


def _values(p: Array) -> Array:
    """Return b, F_c, F_s, v_s from the fit's variables, which keep F_s > F_c > 0."""
    F_c = np.exp(p[1])
    return np.array([p[0], F_c, F_c + np.exp(p[2]), np.exp(p[3])])


def _friction(speed: Array, p: Array, fluctuation: float) -> Array:
    """Return the mean friction (n,) [N] at mean speeds (n,) that fluctuate [m/s].

    Bristles are slower than the fluctuation, which comes from the encoder: their mean force F_f
    obeys v = F_f |v| / g(v) in the mean, and is less than g of the mean speed below about v_s.
    """
    b, F_c, F_s, v_s = p
    v = np.abs(speed[:, np.newaxis] + fluctuation * _NORMAL)
    g = F_c + (F_s - F_c) * np.exp(-np.minimum(v / v_s, 700.0))
    still = speed == 0.0
    held = np.divide(speed, (v / g) @ _WEIGHTS, out=np.full_like(speed, F_s), where=~still)
    return np.asarray(b * speed + held)


def _break_away(rig: Rig, direction: float, first: float) -> tuple[float, float]:
    """Ramp the force up, ever higher, until it slides; return force [N] and rate [N/s]."""
    t = rig.samples(RAMP)
    peak = rig.datasheet.peak_force
    end = min(max(abs(first), 1e-3 * peak), peak)
    while True:
        log = rig.push(direction * end * t / RAMP)
        slow = np.flatnonzero(np.abs(measured_velocity(log.x_enc, rig.T_s)) <= stage.BREAKAWAY)
        if len(slow) and slow[-1] < len(t) - stage.BREAKAWAY_SAMPLES:
            return float(np.abs(log.F_m[: slow[-1] + 1]).max()), end / RAMP
        if end == peak:
            break
        end = min(HIGHER * end, peak)
    raise IdentificationError(
        f"break-away: the peak force of {rig.datasheet.peak_force:g} N does not make the stage "
        "slide"
    )
