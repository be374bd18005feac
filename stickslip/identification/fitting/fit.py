"""Least squares in a parameter space, with a covariance that allows for correlated noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from scipy.optimize import least_squares

from stickslip.catalog.space import ParameterSpace, Values
from stickslip.servo.measurement import Array

STEP = 1e-3  # of a coordinate, for differences
BLOCKS = 100
"""Number of blocks of a recording whose sums of scores are taken to be independent."""
ROUNDS = 30
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
        u = self.space
        known = np.isfinite(u.prior_deviation)
        pull = np.where(known, (self.q - u.prior_mean) / u.prior_deviation**2, 0.0)
        return self.shift(self.residual) - self._inverse() @ pull

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
    measurement; the deviation follows the fit in two passes.
    """
    return min((_fit(criterion, start) for start in starts), key=lambda found: found.noise)


def _fit(criterion: Criterion, start: Array) -> Fit:
    space = criterion.space
    q = space.inside(start)
    deviation = _deviation(criterion.residual(space.decode(q)))
    for _ in range(2):
        target = _Target(criterion, deviation)
        found = least_squares(
            target,
            q,
            jac=target.jacobian,
            bounds=(space.lower, space.upper),
            x_scale="jac",
            max_nfev=ROUNDS,
            xtol=1e-6,
            ftol=1e-7,
        )
        q = space.inside(found.x)
        n = len(found.fun) - len(space.prior_residual(q))
        residual = found.fun[:n] * deviation
        jacobian = np.asarray(found.jac)[:n] * deviation
        before, deviation = deviation, _deviation(residual)
        if deviation > 0.9 * before:
            break
    spread = covariance(jacobian, residual, space)
    return Fit(space, q, residual, jacobian, spread, float(np.mean(residual**2)))


def linearised(criterion: Criterion, q: Array, noise: float) -> Fit:
    """Return residual and Jacobian at coordinates (k,), for a residual of that mean square."""
    space = criterion.space
    points = [q, *_moved(q, space)]
    middle, *moved = criterion.map(space.decode(point) for point in points)
    jacobian = _slopes(middle, moved, q, space)
    spread = inverse_information(jacobian, noise, space)
    return Fit(space, q, middle, jacobian, spread, noise)


class _Target:
    """The function of the least squares: the residual in its deviation, and the prior residual."""

    def __init__(self, criterion: Criterion, deviation: float) -> None:
        self._criterion, self._deviation = criterion, deviation
        self._q, self._value = np.empty(0), np.empty(0)

    def __call__(self, q: Array) -> Array:
        self._q = q.copy()
        (self._value,) = self._at([q])
        return self._value

    def jacobian(self, q: Array) -> Array:
        """Return the Jacobian at coordinates (k,), whose value is mostly known already."""
        middle = self._value if np.array_equal(self._q, q) else self(q)
        space = self._criterion.space
        return _slopes(middle, self._at(list(_moved(q, space))), q, space)

    def _at(self, points: list[Array]) -> list[Array]:
        space = self._criterion.space
        residuals = self._criterion.map([space.decode(q) for q in points])
        return [
            np.append(residual / self._deviation, space.prior_residual(q))
            for residual, q in zip(residuals, points, strict=True)
        ]


def _moved(q: Array, space: ParameterSpace) -> Array:
    """Return coordinates (k, k), in each row another one moved for a difference."""
    return q + np.diag(_steps(q, space))


def _slopes(middle: Array, moved: list[Array], q: Array, space: ParameterSpace) -> Array:
    """Return the Jacobian (n, k) from the values (n,) in the middle and with each one moved."""
    return (np.column_stack(moved) - middle[:, np.newaxis]) / _steps(q, space)


def _steps(q: Array, space: ParameterSpace) -> Array:
    return np.where(q + STEP <= space.upper, STEP, -STEP)


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


def _deviation(residual: Array) -> float:
    return max(float(np.sqrt(np.mean(residual**2))), 1e-300)
