"""The rows of a recording in which the drive slides, and the regression of the force on them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.identification.criteria.motion import SHARE, means, samples_per_row
from stickslip.identification.sliding.regression import Regression, regress
from stickslip.logs.recording import Segment
from stickslip.servo.measurement import Array, derivative, smoothed
from stickslip.thresholds import curve_shown

NOISE = 1e-4  # largest variance of the acceleration by encoder noise, over that of the motion
DISTANCES = (0.004, 0.02)  # travel from a reversal to sliding, as a share of the whole travel
SLOWEST = 0.01  # speed from which on the drive slides, as a share of its top speed
NOISY = 4.0  # the same in standard deviations of the velocity's noise
STEADY = 4.0
"""Largest ratio of speeds within such a distance: friction follows a change of speed over a path,
so that it is not that of a steady speed while a drive sticks and slips."""
GUARDS = (0.32, 0.64)  # distances from rows that are not used, in periods of the cut-off
HARMONICS, KNOTS, STEPS = 40, 10, 6  # bases along the guide, over speed, and since a reversal
ENOUGH = 50_000  # rows, of which more make nothing sharper
DEGREES = 40  # degrees of freedom of the variance within one regression
FIXED = ("m", "b", "F_c", "F_0", "delay")


def shifted(force: Array, T_s: float, delay: float) -> Array:
    """Return a force (n,) without a delay [s]."""
    t = T_s * np.arange(len(force))
    return np.interp(t - delay, t, force) if delay else force


def first_samples(position: Array, T_s: float, noise: float) -> int:
    """Return how many samples a row takes behind the first of two low-passes."""
    first = 2
    while len(position) // first > ENOUGH:
        first *= 2
    return samples_per_row(
        position, T_s, noise, least=first, share=NOISE, rows=2.0 * curve_shown.ROWS
    )


@dataclass(frozen=True)
class Design:
    """The force (n,) of the rows that are used, and what it is regressed on."""

    used: NDArray[np.intp]  # (n,) which rows
    force: Array  # (n,) [N]
    fixed: Array  # (n, f) regressors of ``FIXED``, and others behind them
    groups: Mapping[str, Array]  # (n, j) those of random effects by name
    classes: NDArray[np.intp]  # (n,) of the noise
    size: float  # of the force, which is a large coefficient of a group [N]
    knots: Array  # logarithms of speeds
    speed: Array  # (n,) [m/s]

    def fitted(self, least: Mapping[str, float] | None = None) -> Regression:
        """Return the regression, see ``regress``."""
        return regress(self.force, self.fixed, self.groups, self.classes, least=least)

    def usual(self, found: Regression, name: str, group: str) -> Array:
        """Return the weights (k,) of a coefficient with a group over speed, at the usual speed.

        F_0 has half the difference of friction forward and backward at the usual speed, which an
        asymmetry over speed is a part of.
        """
        weights = np.zeros_like(found.coefficients)
        weights[FIXED.index(name)] = 1.0
        typical = np.log([np.median(self.speed)])
        weights[found.places[group]] = self.size * hats(typical, self.knots)[0]
        return weights


class Rows:
    """A recording behind a low-pass, every q-th sample of it; ``s`` is since the last reversal."""

    def __init__(
        self,
        position: Array,
        force: Array,
        T_s: float,
        noise: float,
        *,
        q: int,
        share: float,
        logs: Sequence[Segment] = (),  # that are joined; by default it is a single one
        factor: Array | None = None,  # (n,) of friction; by default 1
    ) -> None:
        self.q, self.T, self.cutoff = q, q * T_s, SHARE / (q * T_s)
        self.x = self.of_samples(position)
        self.v = derivative(self.x, self.T)
        self.a = derivative(self.v, self.T)
        self.force = self.of_samples(force)
        self.factor = np.ones_like(self.x) if factor is None else self.of_samples(factor)
        logs = logs or (Segment(0, len(position), ""),)
        self.logs = [slice(-(-one.begin // q), one.end // q) for one in logs]
        for log, one in zip(self.logs, logs, strict=True):
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

    def of_samples(self, signal: Array) -> Array:
        """Return a signal of the samples as one of the rows."""
        return smoothed(means(signal, self.q), self.T, self.cutoff)

    def used(self, distance: float, guard: float) -> NDArray[np.intp]:
        """Return the rows before which it slid evenly for this share of its travel."""
        travel, speed = distance * np.ptp(self.x), np.abs(self.v)
        least, greatest = extremes(speed, np.searchsorted(self.path, self.path - travel, "right"))
        steady = (least * STEADY > speed) & (greatest < STEADY * speed)
        good = self.slides & steady & (self.since > travel)
        edge = int(4.0 / self.cutoff / self.T)
        inside = np.zeros(len(good), dtype=bool)
        for log in self.logs:
            inside[log.start + edge : max(log.stop - edge, 0)] = True
        good &= inside
        rows = int(guard / self.cutoff / self.T)
        near = np.convolve(~good, np.ones(2 * rows + 1), "same") > 0.5
        return np.flatnonzero(~near)

    def design(self, distance: float, guard: float, knots: int = KNOTS) -> Design | None:
        """Return the regression for a distance and a guard; None with few rows."""
        used = self.used(distance, guard)
        if len(used) < curve_shown.ROWS:
            return None
        speed = np.maximum(np.abs(self.v), self.slowest)
        ahead = (self.ahead * self.factor)[:, np.newaxis]
        force = self.force[used]
        size = float(np.median(np.abs(force - np.median(force))))
        travel = float(np.ptp(self.x))
        places = np.log(np.geomspace(max(self.slowest, speed[used].min()), self.top, knots))
        steps = np.log(distance * travel * np.geomspace(1.0, 10.0, STEPS))
        waves = self.waves(range(1, HARMONICS + 1))
        over_speed = hats(np.log(speed), places)
        start = hats(np.log(np.maximum(self.s, 1e-3 * distance * travel)), steps)[:, :-1]
        time = np.linspace(-1.0, 1.0, len(self.x))[:, np.newaxis]
        drift = np.hstack([time, time**2 - 1.0 / 3.0])
        rate = np.gradient(self.force)
        fixed = [self.a, self.v, self.low(ahead)[:, 0], np.ones_like(rate), rate]
        groups = {
            "ripple": waves,
            "guide": self.low(ahead * waves),
            "curve": self.low(ahead * over_speed),
            "asymmetry": over_speed,
            "start": self.low(ahead * start),
            "drift": self.low(ahead * drift),
        }
        if len(self.logs) > 1:  # each may have a constant force of its own
            groups["logs"] = self.belongs
        return Design(
            used=used,
            force=force,
            fixed=np.column_stack(fixed)[used],
            groups={name: size * group[used] for name, group in groups.items()},
            classes=3 * _class(speed[used], 4) + _class(self.s[used], 3),
            size=size,
            knots=places,
            speed=speed[used],
        )

    @property
    def belongs(self) -> Array:
        """To which log a row belongs, (n, logs) of 0 and 1."""
        found = np.zeros((len(self.x), len(self.logs)))
        for k, log in enumerate(self.logs):
            found[log, k] = 1.0
        return found

    def waves(self, count: Iterable[int]) -> Array:
        """Return cosines with so many half-waves along the travel (n, len(count))."""
        along = (self.x - self.x.min()) / float(np.ptp(self.x))
        return np.asarray(np.cos(np.pi * along[:, np.newaxis] * np.fromiter(count, int)))

    def low(self, columns: Array) -> Array:
        """Return columns (n, k) behind the low-pass."""
        return smoothed(columns.T, self.T, self.cutoff).T


def extremes(values: Array, begins: NDArray[np.intp]) -> tuple[Array, Array]:
    """Return the least and the greatest of the values (n,) from one of them to each, (n,) both."""
    low = high = values
    least, greatest = values.copy(), values.copy()
    length = np.arange(len(values)) + 1 - begins
    for k in range(int(length.max(initial=1)).bit_length()):  # those of 2**k values from each on
        here = np.flatnonzero(length >> k == 1)
        ends = begins[here], here + 1 - 2**k
        least[here] = np.minimum(*(low[end] for end in ends))
        greatest[here] = np.maximum(*(high[end] for end in ends))
        low = np.minimum(low[: -(2**k)], low[2**k :])
        high = np.maximum(high[: -(2**k)], high[2**k :])
    return least, greatest


def together(values: Array, variances: Array) -> tuple[Array, Array, Array]:
    """Return mean (k,), standard error and half width of the 95 % interval of estimates (j, k)."""
    within, between = variances.mean(axis=0), values.var(axis=0, ddof=1)
    error = np.sqrt(within + between)
    # Welch, Satterthwaite: the degrees of freedom of a sum of variances.
    degrees = error**4 / (within**2 / DEGREES + between**2 / (len(values) - 1))
    return values.mean(axis=0), error, scipy.stats.t.ppf(0.975, degrees) * error


def sizes(
    found: Regression, groups: Mapping[str, Array], names: Iterable[str]
) -> tuple[Array, Array]:
    """Return root mean squares (j,) of the forces of groups, and their standard errors."""
    forces, errors = [], []
    for name in names:
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
