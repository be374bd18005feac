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

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from stickslip.identification.criteria.motion import Scale, position_noise
from stickslip.identification.sliding.regression import Regression
from stickslip.identification.sliding.rows import (
    DISTANCES,
    FIXED,
    GUARDS,
    KNOTS,
    SLOWEST,
    Design,
    Rows,
    first_samples,
    hats,
    shifted,
    sizes,
    together,
)
from stickslip.identification.sliding.stribeck import EXPONENTS, rise
from stickslip.logs.recording import Segment
from stickslip.servo.measurement import Array
from stickslip.thresholds import curve_shown

NEAR = (0.001, 0.004)  # distances as those of ``DISTANCES``, where the curve is to reach low speeds
CREEPS = 0.002  # and the least speed there, as a share of the top speed
CREEP_PERIOD = 1e-3  # least time from row to row there [s]: slips are short
FINE = 20  # and the number of knots
SPEEDS = 12
SPAN = (0.03, 0.97)  # quantiles of the speeds between which the curve is given
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

    def scaled(self, factor: float) -> "Interval":
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

    def restored(self, scale: Scale) -> "FrictionCurve":
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


def friction_curve(
    position: Array,
    force: Array,
    T_s: float,
    step: float,
    *,
    delay: float = 0.0,
    logs: Sequence[Segment] = (),
    factor: Array | None = None,
) -> FrictionCurve | None:
    """Estimate the friction curve of a recording, None where the drive slides too little.

    Position [m] and force [N] are (n,), with this step of the position [m]; the force has about
    this delay [s], which is fitted beside the rest. The logs are those that are joined; by default
    it is a single one. Friction is that where its factor (n,) is 1.
    """
    if len(position) < 8 * curve_shown.ROWS:
        return None
    force, noise = shifted(force, T_s, delay), position_noise(position, step)

    def rows(first: int, share: float) -> list[_Rows]:
        of = partial(_Rows, position, force, T_s, noise, logs=logs, share=share, factor=factor)
        return [of(q=q) for q in (first, 2 * first)]

    first = first_samples(position, T_s, noise)
    found = _estimated(rows(first, SLOWEST), DISTANCES, SPAN, KNOTS)
    if found is None:
        return None
    value, error, width = together(found.values, np.diagonal(found.covariances, axis1=1, axis2=2))
    width[2] = max(width[2], curve_shown.OFFSET * float(np.median(value[3:])))
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


def _rise(slow: "_Estimated") -> dict[str, Interval]:
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
        value, _, width = together(logs[..., 0], ((logs[..., 2] - logs[..., 1]) / 3.92) ** 2)
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


@dataclass(frozen=True)
class _Estimated:
    """The eight estimates."""

    speeds: Array  # (k,)
    values: Array  # (8, 3 + k) m, b, F_0 and the friction at these speeds
    covariances: Array  # (8, 3 + k, 3 + k)
    forces: Array  # (8, j) root mean squares of the forces of ``VARYING``
    errors: Array  # (8, j) their standard errors


def _estimated(
    rows: "list[_Rows]", distances: tuple[float, float], span: tuple[float, float], knots: int
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


class _Rows(Rows):
    """Rows that give a curve."""

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
        design = self.design(distance, guard, knots)
        if design is None:
            return None
        found = design.fitted()
        return *_quantities(found, design, speeds), *sizes(found, design.groups, VARYING)


def _quantities(found: Regression, design: Design, speeds: Array) -> tuple[Array, Array]:
    """Return m, b, F_0 and friction at speeds (k,), together (3 + k,), and their covariance."""
    weights = np.zeros((3 + len(speeds), len(found.coefficients)))
    for row, name in enumerate(("m", "b")):
        weights[row, FIXED.index(name)] = 1.0
    weights[2] = design.usual(found, "F_0", "asymmetry")
    weights[3:, FIXED.index("F_c")] = 1.0
    weights[3:, FIXED.index("b")] = speeds
    weights[3:, found.places["curve"]] = design.size * hats(np.log(speeds), design.knots)
    return weights @ found.coefficients, weights @ found.covariance @ weights.T
