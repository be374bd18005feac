"""Least squares in a parameter space, with a covariance that allows for correlated noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from stickslip.catalog.space import ParameterSpace, Values
from stickslip.servo.measurement import Array

STEP = 1e-3  # of a coordinate, for differences
BLOCKS = 100
"""Number of blocks of a recording whose sums of scores are taken to be independent."""
ROUNDS, TRIES = 30, 8
"""Jacobians of a fit, and damped steps from each, at most."""
DAMPING, FASTER = 1e-3, 8.0
"""First damping, as share of the information, and the factor by which it changes."""
CONVERGED = 1e-3
"""Deviance that a Gauss step must promise for another round; a standard error is 1."""
ROUGH, STALLED = 0.25, 1e-3
"""Share of the promised gain, and of the deviance, below both of which a fit ends."""
SAME = 1e-4
"""Relative difference of mean squares below which two minima are the same."""
TINY = 1e-200
FAR = 2.0
"""Distance from a fit at which a draw of a coordinate ends."""


class Criterion(Protocol):
    """Compares the values of a parameter space with a recording.

    Attributes
    ----------
    name : for people
    space : the parameters and their coordinates
    """

    name: str
    space: ParameterSpace

    def residual(self, values: Values) -> Array:
        """Return the difference that the values leave (n,)."""

    def map(self, points: Iterable[Values]) -> list[Array]:
        """Return the residuals of several points, which may be computed in parallel."""

    def over(self, space: ParameterSpace) -> Self:
        """Return the same criterion over another space."""


@dataclass(frozen=True)
class Fit:
    """The point of the least sum of squares.

    Attributes
    ----------
    space : the meaning of the k coordinates
    q : (k,) coordinates
    residual : (n,) in the criterion's unit
    jacobian : (n, k) of the residual
    covariance : (k, k) of q
    noise : mean square of the residual that counts as noise
    """

    space: ParameterSpace
    q: Array
    residual: Array
    jacobian: Array
    covariance: Array
    noise: float

    @property
    def parameters(self) -> dict[str, float]:
        """The values by name, in SI units."""
        return self.space.decode(self.q)

    @property
    def variance(self) -> float:
        """Mean square of the residual."""
        return float(np.mean(self.residual**2))

    def shift(self, residual: Array) -> Array:
        """Return by how much q would move if this (n,) were added to the residual."""
        return -self._inverse() @ (self.jacobian.T @ residual) / self.noise

    def step(self) -> Array:
        """Return the Gauss step (k,) from here towards the least sum of squares."""
        return self.shift(self.residual) - self._inverse() @ self.pull()

    def length(self, step: Array) -> float:
        """Return by how much a step (k,) from the least deviance raises it, linearised."""
        change = self.jacobian @ step
        prior = _prior_information(self.space) @ step**2
        return float(change @ change) / self.noise + float(prior)

    def pull(self) -> Array:
        """Return half the gradient (k,) of the squared prior residual."""
        return _prior_information(self.space) * (self.q - self.space.prior_mean)

    @property
    def deviance(self) -> float:
        """Twice the negative log likelihood, up to a constant, and the squared prior residual."""
        prior = self.space.prior_residual(self.q)
        return float(self.residual @ self.residual) / self.noise + float(prior @ prior)

    def _inverse(self) -> Array:
        return inverse_information(self.jacobian, self.noise, self.space)

    def errors(self) -> dict[str, float]:
        """Return the standard errors of the values by name, in SI units."""
        return value_errors(self.space, self.q, self.covariance)


def plausible(fitted: Fit, seed: int, count: int) -> tuple[dict[str, float], ...]:
    """Return the values by name of a fit, and of draws from its covariance."""
    space, rng = fitted.space, np.random.default_rng(seed)
    draws = rng.multivariate_normal(np.zeros(len(fitted.q)), fitted.covariance, count)
    points = np.clip(fitted.q + np.clip(draws, -FAR, FAR), space.lower, space.upper)
    return tuple(space.decode(q) for q in (fitted.q, *points))


def value_errors(space: ParameterSpace, q: Array, covariance: Array) -> dict[str, float]:
    """Return standard errors by name [SI] from a covariance (k, k) of coordinates."""
    slopes = space.jacobian(q)
    spread = np.sqrt(np.maximum(np.diag(slopes @ covariance @ slopes.T), 0.0))
    return dict(zip(space.names, spread.tolist(), strict=True))


def fit(criterion: Criterion, starts: Iterable[Array]) -> Fit:
    """Minimise residual and prior residual from each start (k,); return the least minimum.

    The residual is counted in its own standard deviation, so that each prior weighs as one more
    measurement. When two starts have led to the same minimum, those that follow are left out.
    """
    least: Fit | None = None
    for start in starts:
        found = _fit(criterion, start)
        if least and abs(found.noise - least.noise) < SAME * least.noise:
            return min(found, least, key=lambda one: one.noise)
        least = min(found, least or found, key=lambda one: one.noise)
    if least is None:
        raise ValueError("a fit needs a start")
    return least


def _fit(criterion: Criterion, start: Array) -> Fit:
    """Minimise by the method of Levenberg and Marquardt.

    A Jacobian takes a run for each coordinate, so no further one is computed where the last one
    promises little, or where the sum of squares is so rough that its promises are not kept.
    """
    space = criterion.space
    q, damping, stalled = space.inside(start), DAMPING, False
    residual = criterion.residual(space.decode(q))
    for _ in range(ROUNDS):
        at = linearised(criterion, q, max(float(np.mean(residual**2)), TINY))
        problem = NormalEquations.of(at)
        gauss = problem.step()
        if problem.gain(gauss) < CONVERGED:
            at = replace(at, q=q + gauss, residual=at.residual + at.jacobian @ gauss)
            break
        if stalled:
            break
        for _ in range(TRIES):
            step = problem.step(damping)
            residual = criterion.residual(space.decode(q + step))
            gain = at.deviance - replace(at, q=q + step, residual=residual).deviance
            if gain > 0.0:
                break
            damping *= FASTER
        else:
            break
        kept = gain / problem.gain(step)
        stalled = kept < ROUGH and gain < STALLED * at.deviance
        damping *= 1.0 / FASTER if kept > 0.5 else 1.0
        q = q + step
    spread = covariance(at.jacobian, at.residual, space)
    return replace(at, covariance=spread, noise=at.variance)


def linearised(criterion: Criterion, q: Array, noise: float) -> Fit:
    """Return residual and Jacobian at coordinates (k,), for a residual of that mean square."""
    space = criterion.space
    steps = np.where(q + STEP <= space.upper, STEP, -STEP)
    points = [q, *(q + np.diag(steps))]
    middle, *moved = criterion.map([space.decode(point) for point in points])
    jacobian = (np.column_stack(moved) - middle[:, np.newaxis]) / steps
    spread = inverse_information(jacobian, noise, space)
    return Fit(space, q, middle, jacobian, spread, noise)


@dataclass(frozen=True)
class NormalEquations:
    """The linear least squares around a point.

    Attributes
    ----------
    matrix : (k, k) information of residual and priors
    slope : (k,) half the gradient of the deviance
    low, high : (k,) least and largest step that the bounds allow
    """

    matrix: Array
    slope: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, at: Fit) -> Self:
        """Return them for the point of a fit."""
        matrix = at.jacobian.T @ at.jacobian / at.noise + np.diag(_prior_information(at.space))
        slope = at.jacobian.T @ at.residual / at.noise + at.pull()
        return cls(matrix, slope, at.space.lower - at.q, at.space.upper - at.q)

    def step(self, damping: float = 0.0) -> Array:
        """Return the step (k,) of Gauss, or a damped one; what would pass a bound stops there."""
        scale = np.sqrt(np.maximum(np.diag(self.matrix), TINY))
        matrix = self.matrix / np.outer(scale, scale) + damping * np.eye(len(scale))
        low, high = self.low * scale, self.high * scale
        step, free = np.zeros_like(scale), np.ones(len(scale), dtype=bool)
        while free.any():
            wanted = -self.slope / scale - matrix[:, ~free] @ step[~free]
            step[free] = np.linalg.lstsq(matrix[np.ix_(free, free)], wanted[free])[0]
            beyond = free & ((step < low) | (step > high))
            if not beyond.any():
                break
            step[beyond] = np.clip(step, low, high)[beyond]
            free &= ~beyond
        return np.clip(step / scale, self.low, self.high)

    def gain(self, step: Array) -> float:
        """Return by how much a step (k,) lowers the deviance of the linear problem."""
        return -float(2.0 * self.slope @ step + step @ self.matrix @ step)


def inverse_information(jacobian: Array, variance: float, space: ParameterSpace) -> Array:
    """Return (J'J / variance + prior information)^-1, (k, k)."""
    information = jacobian.T @ jacobian / variance + np.diag(_prior_information(space))
    return np.asarray(np.linalg.pinv(information, hermitian=True), dtype=float)


def covariance(jacobian: Array, residual: Array, space: ParameterSpace) -> Array:
    """Return the covariance (k, k) of a fit whose residual may be correlated and uneven.

    The priors count as independent measurements.

    Source
    ------
    White, Econometrica 48 (1980) 817, with blocks in place of samples.
    """
    variance = max(float(np.mean(residual**2)), np.finfo(float).tiny)
    inverse = inverse_information(jacobian, variance, space)
    scores = jacobian * residual[:, np.newaxis] / variance
    blocks = np.array([block.sum(axis=0) for block in np.array_split(scores, BLOCKS)])
    factor = BLOCKS / (BLOCKS - jacobian.shape[1])
    information = factor * blocks.T @ blocks + np.diag(_prior_information(space))
    return np.asarray(inverse @ information @ inverse)


def _prior_information(space: ParameterSpace) -> Array:
    known = np.isfinite(space.prior_deviation)
    return np.where(known, 1.0 / space.prior_deviation, 0.0) ** 2
