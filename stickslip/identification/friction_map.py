"""Stage 2: friction over velocity in both directions, and the break-away force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from cosim.control import VelocityLoop
from stickslip.errors import IdentificationError
from stickslip.identification.estimate import Estimate, covariance
from stickslip.measurement import Array, measured_velocity
from stickslip.rig import Rig

SPEEDS = np.geomspace(0.25e-3, 40e-3, 12)  # [m/s]
SETTLE = 2.0  # before the force is averaged [s]
AVERAGE = 2.0  # [s]
BLOCKS = 8  # means whose scatter gives the standard error of a point
RAMP = 0.25  # rate of the break-away ramp, in Coulomb forces per second
SLIDING = 2e-3  # velocity that counts as break-away: no bristle creeps as fast [m/s]


@dataclass(frozen=True)
class FrictionMap:
    """Result of stage 2.

    Attributes
    ----------
    b, F_c, F_s, v_s : of F(v) = b v + F_c + (F_s - F_c) exp(-|v| / v_s) [N s/m, N, N, m/s]
    velocity, force, error : (n,) the points: speed with its sign [m/s], mean force and its
        standard error [N]
    breakaway : force at which the stage broke away, forward and back [N]
    ramp_rate : of the force that led there, at first [N/s]; a faster ramp breaks away later
    """

    b: Estimate
    F_c: Estimate
    F_s: Estimate
    v_s: Estimate
    velocity: Array
    force: Array
    error: Array
    breakaway: tuple[float, float]
    ramp_rate: float

    def curve(self, v: Array) -> Array:
        """Return the fitted friction (n,) [N] at velocities (n,) [m/s]."""
        values = np.array([e.value for e in (self.b, self.F_c, self.F_s, self.v_s)])
        return np.sign(v) * _friction(np.abs(v), values)


def measure_friction(rig: Rig, loop: VelocityLoop, coarse_F_c: float) -> FrictionMap:
    """Drive at constant velocities, break away from rest, and fit the Stribeck curve.

    Parameters
    ----------
    loop : holds the velocity
    coarse_F_c : Coulomb friction of stage 1, which scales the ramp [N]

    Raises
    ------
    IdentificationError
        When the stage does not break away, or the points show no friction.
    """
    velocity = np.concatenate([-SPEEDS[::-1], SPEEDS])
    points = np.array([_mean_force(rig, loop, v) for v in velocity])
    force, error = points.T
    rate = RAMP * abs(coarse_F_c)
    breakaway = (_break_away(rig, rate, 1.0), _break_away(rig, rate, -1.0))

    # Both directions together; an offset and an asymmetry cancel. Standstill is F_s.
    speed = np.append(0.0, SPEEDS)
    half = len(SPEEDS)
    mean = np.append(np.mean(breakaway), (force[half:] - force[:half][::-1]) / 2.0)
    scatter = np.append(0.02 * np.mean(breakaway), np.hypot(error[half:], error[:half][::-1]) / 2.0)
    weight = 1.0 / np.maximum(scatter, 1e-3 * mean.max())

    def residual(p: Array) -> Array:
        return np.asarray((_friction(speed, _values(p)) - mean) * weight)

    low = max(float(mean[1:].min()), 1e-3 * float(mean.max()))
    rise = max(float(mean.max()) - low, 1e-3 * low)
    fits = [
        least_squares(residual, [0.0, np.log(low), np.log(rise), np.log(v_s)], x_scale="jac")
        for v_s in np.geomspace(SPEEDS[0], SPEEDS[-1] / 4, 4)
    ]
    fit = min(fits, key=lambda candidate: candidate.cost)
    values = _values(fit.x)
    slope = np.diag(np.append(1.0, np.exp(fit.x[1:])))
    slope[2, 1] = values[1]  # F_s is F_c and a rise
    spread = slope @ covariance(np.asarray(fit.jac), fit.fun) @ slope.T
    b, F_c, F_s, v_s = (
        Estimate(float(value), float(error))
        for value, error in zip(values, np.sqrt(np.diag(spread)), strict=True)
    )
    return FrictionMap(b, F_c, F_s, v_s, velocity, force, error, breakaway, rate)


def _values(p: Array) -> Array:
    """Return b, F_c, F_s, v_s from the fit's variables, which keep F_s > F_c > 0."""
    F_c = np.exp(p[1])
    return np.array([p[0], F_c, F_c + np.exp(p[2]), np.exp(p[3])])


def _friction(speed: Array, p: Array) -> Array:
    b, F_c, F_s, v_s = p
    return np.asarray(b * speed + F_c + (F_s - F_c) * np.exp(-speed / v_s))


def _mean_force(rig: Rig, loop: VelocityLoop, v: float) -> tuple[float, float]:
    """Return mean motor force [N] at constant velocity v [m/s], and its standard error."""
    t = rig.samples(SETTLE + AVERAGE)
    log = rig.follow(np.full_like(t, v), loop)
    blocks = [part.mean() for part in np.array_split(log.F_m[t >= SETTLE], BLOCKS)]
    return float(np.mean(blocks)), float(np.std(blocks, ddof=1) / np.sqrt(BLOCKS))


def _break_away(rig: Rig, rate: float, direction: float) -> float:
    """Ramp the force up from rest until the stage slides; return the force [N] without sign.

    A ramp that ends before is repeated at twice the rate, up to the peak force.
    """
    t = rig.samples(8.0 / RAMP)
    while rate * t[-1] < 2.0 * rig.datasheet.peak_force:
        log = rig.push(direction * rate * t)
        slid = np.flatnonzero(np.abs(measured_velocity(log.x_enc, rig.T_s)) > SLIDING)
        if len(slid):
            return float(np.abs(log.F_m[: slid[0]]).max())
        rate *= 2.0
    raise IdentificationError(
        f"break-away: the peak force of {rig.datasheet.peak_force:g} N does not make the stage "
        "slide"
    )
