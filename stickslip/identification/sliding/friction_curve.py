"""Mass, offset and friction against speed, from where the drive slides and without a friction law.

    F(t - delay) = m a + b v + sign(v) (F_c + curve(|v|)) + F_0 + asymmetry(|v|)
                   + ripple(x) + sign(v) (guide(x) + start(s) + drift(t))

s is the travel since the last reversal. ``curve``, ``asymmetry``, ``ripple``, ``guide``, ``start``
and ``drift`` are smooth functions whose sizes follow from the recording (random effects): what a
drive does not have costs no precision. All terms are low-passed alike.

The regression is made with two low-passes, over two distances along which the speed was held, and
with two guards around what is left out. A bias by encoder noise changes with the low-pass, one by
bristles that still bend with the distance, and one by slips with the guard, so the differences
between the eight show what is not known and are a part of the intervals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import t as student

from stickslip.identification.criteria.motion import (
    SHARE,
    Scale,
    means,
    position_noise,
    samples_per_row,
)
from stickslip.identification.sliding.regression import Regression, regress
from stickslip.identification.sliding.stribeck import EXPONENTS, rise
from stickslip.servo.measurement import Array, derivative, smoothed
from stickslip.thresholds import curve_shown

NOISE = 1e-4  # largest variance of the acceleration by encoder noise, over that of the motion
DISTANCES = (0.004, 0.02)  # travel from a reversal to sliding, as a share of the whole travel
SLOWEST = 0.01  # speed from which on the drive slides, as a share of its top speed
NOISY = 4.0  # the same in standard deviations of the velocity's noise
STEADY = 4.0
"""Largest ratio of speeds within such a distance: friction follows a change of speed over a path,
so that it is not that of a steady speed while a drive sticks and slips."""
NEAR = (0.001, 0.004)  # the same distances where the curve is to reach low speeds
CREEPS = 0.002  # and the same speed there
CREEP_PERIOD = 1e-3  # least time from row to row there [s]: slips are short
FINE = 20  # and the number of knots
GUARDS = (0.32, 0.64)  # distances from rows that are not used, in periods of the cut-off
HARMONICS, KNOTS, STEPS = 40, 10, 6  # bases along the guide, over speed, and since a reversal
ENOUGH = 50_000  # rows, of which more make nothing sharper
SPEEDS = 12
SPAN = (0.03, 0.97)  # quantiles of the speeds between which the curve is given
DEGREES = 40  # degrees of freedom of the variance within one regression
FIXED = ("m", "b", "F_c", "F_0", "delay")
VARYING = {
    "ripple": "the force varies along the guide",
    "guide": "friction varies along the guide",
    "drift": "friction drifts",
}
"""Display names of the groups of regressors that no friction law has."""


@dataclass(frozen=True)
class Interval:
    """A value with a standard error and a 95 % interval, in SI units."""

    value: float
    standard_error: float
    low: float
    high: float

    def scaled(self, factor: float) -> Interval:
        """Return the interval of the value times a positive factor."""
        return Interval(*(factor * one for one in vars(self).values()))


@dataclass(frozen=True)
class FrictionCurve:
    """What sliding motion shows of a drive, whatever its friction law."""

    speed: Array  # (k,) at which the drive slides in the recording, rising [m/s]
    # (k,) friction with its viscous part, and its 95 % intervals [N]; mean of both directions and
    # of the travel
    value: Array
    low: Array
    high: Array
    mass: Interval  # moving mass [kg]
    viscous: Interval  # slope of friction over speed, beside the Stribeck effect [N s/m]
    # constant force against the motor, with half the difference of friction forward and backward
    # [N]
    offset: Interval
    varying: dict[str, float]  # root mean square [N] of the forces of ``VARYING`` that are certain
    rise: dict[str, Interval]  # F_s and v_s, where friction is seen to rise towards rest
    near: float  # travel over which a speed was held at least, where that is seen [m]

    def restored(self, scale: Scale) -> FrictionCurve:
        """Return the curve of a scaled recording in SI units."""
        force = 1.0 / scale.force
        return replace(
            self,
            speed=self.speed / scale.length,
            value=self.value * force,
            low=self.low * force,
            high=self.high * force,
            mass=self.mass.scaled(1.0 / scale.of("m")),
            viscous=self.viscous.scaled(1.0 / scale.of("b")),
            offset=self.offset.scaled(force),
            varying={name: one * force for name, one in self.varying.items()},
            rise={
                name: one.scaled(force) if name == "F_s" else one.scaled(1.0 / scale.length)
                for name, one in self.rise.items()
            },
            near=self.near / scale.length,
        )


class Span(NamedTuple):
    """Where one log is in a recording, and the mass that it moves beside that of the drive [kg]."""

    begin: int
    end: int
    load: float = 0.0


def friction_curve(
    position: Array,
    force: Array,
    T_s: float,
    step: float,
    *,
    delay: float = 0.0,
    spans: Sequence[Span] = (),
) -> FrictionCurve | None:
    """Estimate the friction curve of a recording, None where the drive slides too little.

    Position [m] and force [N] are (n,), with this step of the position [m]; the force has about
    this delay [s], which is fitted beside the rest. The spans are those of the logs; by default
    it is a single one.
    """
    spans = spans or (Span(0, len(position)),)
    if len(position) < 8 * curve_shown.ROWS:
        return None
    t = T_s * np.arange(len(position))
    force = np.interp(t - delay, t, force) if delay else force
    noise = position_noise(position, step)

    def rows(first: int, share: float) -> list[Rows]:
        each = (first, 2 * first)
        return [Rows(position, force, T_s, noise, spans=spans, q=q, share=share) for q in each]

    first = 2
    while len(position) // first > ENOUGH:
        first *= 2
    first = samples_per_row(
        position, T_s, noise, least=first, share=NOISE, rows=2.0 * curve_shown.ROWS
    )
    found = _estimated(rows(first, SLOWEST), DISTANCES, SPAN, KNOTS)
    if found is None:
        return None
    value, error, width = _together(found.values, np.diagonal(found.covariances, axis1=1, axis2=2))
    mass, viscous, offset = (
        Interval(*map(float, (value[i], error[i], value[i] - width[i], value[i] + width[i])))
        for i in range(3)
    )
    low, high = (value - width)[3:], (value + width)[3:]
    certain = np.all(found.forces > curve_shown.CERTAIN * found.errors, axis=0)
    forces = found.forces.mean(axis=0).tolist()
    varying = {
        name: force for name, force, sure in zip(VARYING, forces, certain, strict=True) if sure
    }
    first = max(first // 2, round(CREEP_PERIOD / T_s), 1)
    slow = _estimated(rows(first, CREEPS), NEAR, (0.0, SPAN[1]), FINE)
    return FrictionCurve(
        found.speeds,
        value[3:],
        low,
        high,
        mass=mass,
        viscous=viscous,
        offset=offset,
        varying=varying,
        rise=_rise(slow) if slow else {},
        near=NEAR[0] * float(np.ptp(position)),
    )


def _rise(slow: _Estimated) -> dict[str, Interval]:
    """Return F_s and v_s by name, from the logarithms of those of the eight curves.

    The intervals hold both exponents of the Stribeck curve, unless one is much worse.
    """
    ends, deviances = [], []
    for delta in EXPONENTS:
        curves = zip(slow.values, slow.covariances, strict=True)
        found = [rise(slow.speeds, value[3:], error[3:, 3:], delta) for value, error in curves]
        known = [one for one in found if one is not None]
        if len(known) < len(found):
            continue
        logs = np.log([(one.F_s, one.v_s) for one in known])  # (8, 2, 3)
        value, _, width = _together(logs[..., 0], ((logs[..., 2] - logs[..., 1]) / 3.92) ** 2)
        ends.append(np.exp([value, value - width, value + width]))
        deviances.append(sum(one.deviance for one in known))
    if not ends:
        return {}
    most = curve_shown.EXPONENT * min(deviances)
    able = [one for one, apart in zip(ends, deviances, strict=True) if apart <= most]
    best = ends[int(np.argmin(deviances))][0]
    low, high = (np.array(able)[:, 1].min(axis=0), np.array(able)[:, 2].max(axis=0))
    return {
        name: Interval(*map(float, (best[k], (high[k] - low[k]) / 4.0, low[k], high[k])))
        for k, name in enumerate(("F_s", "v_s"))
    }


def _together(values: Array, variances: Array) -> tuple[Array, Array, Array]:
    """Return mean (k,), standard error and half width of the 95 % interval of estimates (8, k)."""
    within, between = variances.mean(axis=0), values.var(axis=0, ddof=1)
    error = np.sqrt(within + between)
    # Welch, Satterthwaite: the degrees of freedom of a sum of variances.
    degrees = error**4 / (within**2 / DEGREES + between**2 / (len(values) - 1))
    return values.mean(axis=0), error, student.ppf(0.975, degrees) * error


@dataclass(frozen=True)
class _Estimated:
    """The eight estimates."""

    speeds: Array  # (k,)
    values: Array  # (8, 3 + k) m, b, F_0 and the friction at these speeds
    covariances: Array  # (8, 3 + k, 3 + k)
    forces: Array  # (8, j) root mean squares of the forces of ``VARYING``
    errors: Array  # (8, j) their standard errors


def _estimated(
    rows: list[Rows], distances: tuple[float, float], span: tuple[float, float], knots: int
) -> _Estimated | None:
    """Return the estimates of both low-passes, distances and guards; None without one of them."""
    speeds = rows[-1].speeds(distances[-1], GUARDS[-1], span)
    if speeds is None:
        return None
    ways = product(rows, distances, GUARDS)
    found = [row.estimate(distance, guard, speeds, knots) for row, distance, guard in ways]
    estimates = [one for one in found if one is not None]
    if len(estimates) < len(found):
        return None
    return _Estimated(speeds, *map(np.array, zip(*estimates, strict=True)))


class Rows:
    """A recording behind a low-pass, every q-th sample of it; ``s`` is since the last reversal."""

    def __init__(
        self,
        position: Array,
        force: Array,
        T_s: float,
        noise: float,
        *,
        spans: Sequence[Span],
        q: int,
        share: float,
    ) -> None:
        self.T, self.cutoff = q * T_s, SHARE / (q * T_s)
        self.x = smoothed(means(position, q), self.T, self.cutoff)
        self.v = derivative(self.x, self.T)
        self.a = derivative(self.v, self.T)
        self.force = smoothed(means(force, q), self.T, self.cutoff)
        self.logs = [slice(-(-one.begin // q), one.end // q) for one in spans]
        for log, one in zip(self.logs, spans, strict=True):
            self.force[log] -= one.load * self.a[log]
        own = noise * 2.0 * np.pi * self.cutoff * np.sqrt(2.0 * self.cutoff * T_s)
        self.top, noisy = float(np.quantile(np.abs(self.v), 0.99)), NOISY * own
        self.slowest = max(noisy, share * self.top)
        self.slides = np.abs(self.v) > self.slowest
        moves = np.abs(self.v) > max(noisy, SLOWEST * self.top)
        last = np.maximum.accumulate(np.where(moves, np.arange(len(moves)), 0))
        self.ahead = np.sign(self.v)[last]
        self.path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.x)))])
        turned = np.append(False, np.diff(self.ahead) != 0.0)
        begins = [log.start for log in self.logs]
        turned[begins] = True
        first = np.searchsorted(begins, np.arange(len(self.path)), side="right") - 1
        self.since = self.path - self.path[begins][first]  # since the log began
        self.s = self.path - np.maximum.accumulate(np.where(turned, self.path, 0.0))

    def used(self, distance: float, guard: float) -> NDArray[np.intp]:
        """Return the rows before which it slid evenly for this share of its travel."""
        path = pd.to_timedelta(self.path / (distance * np.ptp(self.x)), unit="s")
        speed = pd.Series(np.abs(self.v), path)
        before = speed.rolling("1s")  # of travel
        steady = (before.min() * STEADY > speed) & (before.max() < STEADY * speed)
        good = self.slides & steady.to_numpy() & (self.since > distance * np.ptp(self.x))
        edge = int(4.0 / self.cutoff / self.T)
        inside = np.zeros(len(good), dtype=bool)
        for log in self.logs:
            inside[log.start + edge : max(log.stop - edge, 0)] = True
        good &= inside
        rows = int(guard / self.cutoff / self.T)
        near = np.convolve(~good, np.ones(2 * rows + 1), "same") > 0.5
        return np.flatnonzero(~near)

    def speeds(self, distance: float, guard: float, span: tuple[float, float]) -> Array | None:
        """Return the speeds (k,) of the curve, None with few rows."""
        used = self.used(distance, guard)
        if len(used) < curve_shown.ROWS:
            return None
        low, high = np.quantile(np.abs(self.v[used]), span)
        return np.geomspace(low, high, SPEEDS)

    def estimate(
        self, distance: float, guard: float, speeds: Array, knots: int
    ) -> tuple[Array, Array, Array, Array] | None:
        """Return m, b, F_0 and the friction at k speeds (3 + k,), and their covariance.

        Beside them: root mean squares of the forces of ``VARYING``, and their standard errors.
        """
        used = self.used(distance, guard)
        if len(used) < curve_shown.ROWS:
            return None
        speed, ahead = np.maximum(np.abs(self.v), self.slowest), self.ahead[:, np.newaxis]
        force = self.force[used]
        size = float(np.median(np.abs(force - np.median(force))))
        travel = float(np.ptp(self.x))
        places = np.log(np.geomspace(max(self.slowest, speed[used].min()), self.top, knots))
        steps = np.log(distance * travel * np.geomspace(1.0, 10.0, STEPS))
        along = (self.x - self.x.min()) / travel
        waves = np.cos(np.pi * along[:, np.newaxis] * np.arange(1, HARMONICS + 1))
        over_speed = hats(np.log(speed), places)
        start = hats(np.log(np.maximum(self.s, 1e-3 * distance * travel)), steps)[:, :-1]
        time = np.linspace(-1.0, 1.0, len(self.x))[:, np.newaxis]
        drift = np.hstack([time, time**2 - 1.0 / 3.0])
        rate = np.gradient(self.force)
        fixed = np.column_stack([self.a, self.v, self.low(ahead)[:, 0], np.ones_like(rate), rate])[
            used
        ]
        groups = {
            "ripple": waves,
            "guide": self.low(ahead * waves),
            "curve": self.low(ahead * over_speed),
            "asymmetry": over_speed,
            "start": self.low(ahead * start),
            "drift": self.low(ahead * drift),
        }
        groups = {name: size * group[used] for name, group in groups.items()}
        classes = 3 * _class(speed[used], 4) + _class(self.s[used], 3)
        found = regress(force, fixed, groups, classes)
        return (
            *_quantities(found, size, places, speeds, typical=float(np.median(speed[used]))),
            *_varying(found, groups),
        )

    def low(self, columns: Array) -> Array:
        """Return columns (n, k) behind the low-pass."""
        return smoothed(columns.T, self.T, self.cutoff).T


def _quantities(
    found: Regression, size: float, knots: Array, speeds: Array, typical: float
) -> tuple[Array, Array]:
    """Return m, b, F_0 and friction at speeds (k,), together (3 + k,), and their covariance."""
    weights = np.zeros((3 + len(speeds), len(found.coefficients)))
    for row, name in enumerate(("m", "b", "F_0")):
        weights[row, FIXED.index(name)] = 1.0
    weights[2, found.places["asymmetry"]] = size * hats(np.log([typical]), knots)[0]
    weights[3:, FIXED.index("F_c")] = 1.0
    weights[3:, FIXED.index("b")] = speeds
    weights[3:, found.places["curve"]] = size * hats(np.log(speeds), knots)
    return weights @ found.coefficients, weights @ found.covariance @ weights.T


def _varying(found: Regression, groups: Mapping[str, Array]) -> tuple[Array, Array]:
    """Return root mean squares (j,) of the forces of ``VARYING``, and their standard errors."""
    forces, errors = [], []
    for name in VARYING:
        x, place = groups[name], found.places[name]
        forces.append(float(np.std(x @ found.coefficients[place])))
        covariance = found.covariance[place, place]
        errors.append(float(np.sqrt(np.mean(np.sum(x @ covariance * x, axis=1)))))
    return np.array(forces), np.array(errors)


def hats(z: Array, knots: Array) -> Array:
    """Return piecewise linear functions (n, k) of z (n,), each 1 at one knot and 0 at others."""
    return np.column_stack([np.interp(z, knots, one) for one in np.eye(len(knots))])


def _class(z: Array, n: int) -> NDArray[np.intp]:
    """Return in which of n classes of like size each value (k,) is."""
    return np.asarray(np.digitize(z, np.quantile(z, np.arange(1, n) / n)))
