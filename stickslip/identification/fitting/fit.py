"""Least squares in a parameter space, with a covariance that allows for correlated noise."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from stickslip.catalog.parameters import ParameterSpace
from stickslip.identification.criteria.runs import Criterion
from stickslip.servo.measurement import Array

STEP = 1e-3  # of a coordinate, for differences
BLOCKS = 100  # number of blocks of a recording whose sums of scores are taken to be independent
ROUNDS = 30
ROUNDED = 1e-15  # relative size of an eigenvalue that is none, as of numpy.linalg.pinv
BLIND = 10.0  # standard error of a coordinate that nothing depends on
XTOL, FTOL = 1e-6, 1e-7
ROUGH = 1e-4  # relative change of the sum of squares at which a fit ends that another one continues
SAME = 1e-4  # relative difference of mean squares below which two minima are the same
TINY = 1e-200
FAR = 2.0  # distance from a fit at which a draw of a coordinate ends


@dataclass(frozen=True)
class Fit:
    """The point of the least sum of squares."""

    space: ParameterSpace  # the meaning of the k coordinates
    q: Array  # (k,) coordinates
    residual: Array  # (n,) in the criterion's unit
    jacobian: Array  # (n, k) of the residual
    covariance: Array  # (k, k) of q
    noise: float  # mean square of the residual that counts as noise

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
        pull = _prior_information(u) * (self.q - u.prior_mean)
        return self.shift(self.residual) - self._inverse() @ pull

    def length(self, step: Array) -> float:
        """Return by how much a step (k,) from the least deviance raises it, linearised."""
        change = self.jacobian @ step
        prior = _prior_information(self.space) @ step**2
        return float(change @ change) / self.noise + float(prior)

    def _inverse(self) -> Array:
        return inverse_information(self.jacobian, self.noise, self.space)

    def errors(self) -> dict[str, float]:
        """Return the standard errors of the values by name, in SI units."""
        return value_errors(self.space, self.q, self.covariance)


DRAWS = 3  # draws from the covariance of a fit, on which a compensator is tried


def plausible(fitted: Fit, seed: int) -> tuple[dict[str, float], ...]:
    """Return the values by name of a fit, and of draws from its covariance."""
    space, rng = fitted.space, np.random.default_rng(seed)
    mean, spread = np.zeros(len(fitted.q)), fitted.covariance
    draws = rng.multivariate_normal(mean, spread, DRAWS, check_valid="ignore")  # its rounding
    points = np.clip(fitted.q + np.clip(draws, -FAR, FAR), space.lower, space.upper)
    return tuple(space.decode(q) for q in (fitted.q, *points))


def value_errors(space: ParameterSpace, q: Array, covariance: Array) -> dict[str, float]:
    """Return standard errors by name [SI] from a covariance (k, k) of coordinates."""
    slopes = space.jacobian(q)
    spread = np.sqrt(np.maximum(np.diag(slopes @ covariance @ slopes.T), 0.0))
    return dict(zip(space.names, spread.tolist(), strict=True))


def fit(criterion: Criterion, starts: Iterable[Array], ftol: float = FTOL) -> Fit:
    """Minimise residual and prior residual from each start (k,); return the least minimum.

    The residual is counted in its own standard deviation, so that each prior weighs as one more
    measurement. When two starts have led to the same minimum, those that follow are left out. It
    ends at a relative change ``ftol`` of the sum of squares.
    """
    least: Fit | None = None
    for start in starts:
        found = _fit(criterion, start, ftol)
        if least and abs(found.noise - least.noise) < SAME * least.noise:
            return min(found, least, key=lambda one: one.noise)
        least = min(found, least or found, key=lambda one: one.noise)
    if least is None:
        raise ValueError("a fit needs a start")
    return least


def _fit(criterion: Criterion, start: Array, ftol: float) -> Fit:
    """Minimise from a start (k,); the residual's deviation follows the fit in two passes."""
    space = criterion.space
    q, free = space.inside(start), space.upper > space.lower

    def weighted(residual: Array, q: Array) -> Array:
        few = residual[:: criterion.every] * (criterion.every**0.5 / deviation)
        return np.append(few, space.prior_residual(q))

    def around(z: Array) -> list[Array]:
        q[free] = z
        return [q, *(q + np.diag(_steps(q, space))[free])]

    def at(z: Array) -> Array:
        criterion.run(map(space.decode, around(z)))  # most steps succeed; then these are needed
        return weighted(criterion.residual(space.decode(q)), q)

    def slopes(z: Array) -> Array:
        points = around(z)
        middle, *moved = map(weighted, criterion.map(map(space.decode, points)), points)
        return (np.column_stack(moved) - middle[:, np.newaxis]) / _steps(q, space)[free]

    deviation = _deviation(criterion.residual(space.decode(q)))
    for _ in range(2):
        found = least_squares(
            at,
            q[free],
            jac=slopes,
            bounds=(space.lower[free], space.upper[free]),
            x_scale="jac",
            max_nfev=ROUNDS,
            xtol=XTOL,
            ftol=ftol,
        )
        q[free] = found.x
        q = space.inside(q)
        residual = criterion.residual(space.decode(q))
        before, deviation = deviation, _deviation(residual)
        if deviation > 0.9 * before:
            break
    fitted = linearised(criterion, q, max(float(np.mean(residual**2)), TINY))
    return replace(fitted, covariance=covariance(fitted.jacobian, fitted.residual, space))


def linearised(criterion: Criterion, q: Array, noise: float) -> Fit:
    """Return residual and Jacobian at coordinates (k,), for a residual of that mean square."""
    space = criterion.space
    steps = _steps(q, space)
    points = [q, *(q + np.diag(steps))]
    middle, *moved = criterion.map([space.decode(point) for point in points])
    jacobian = (np.column_stack(moved) - middle[:, np.newaxis]) / steps
    spread = inverse_information(jacobian, noise, space)
    return Fit(space, q, middle, jacobian, covariance=spread, noise=noise)


def _steps(q: Array, space: ParameterSpace) -> Array:
    return np.where(q + STEP <= space.upper, STEP, -STEP)


def _deviation(residual: Array) -> float:
    return max(float(np.sqrt(np.mean(residual**2))), 1e-300)


def inverse_information(jacobian: Array, variance: float, space: ParameterSpace) -> Array:
    """Return (J'J / variance + prior information)^-1, (k, k), without what has no information.

    An eigenvalue that rounding makes negative counts by its size: its variance is large. So is that
    of a coordinate that nothing depends on.
    """
    information = jacobian.T @ jacobian / variance + np.diag(_prior_information(space))
    values, vectors = np.linalg.eigh(information)
    some = np.abs(values) > ROUNDED * np.abs(values).max(initial=0.0)
    return _with_blind(vectors[:, some] / np.abs(values[some]) @ vectors[:, some].T, information)


def _with_blind(covariance: Array, information: Array) -> Array:
    """Return a covariance (k, k) in which coordinates without information are not known."""
    blind = np.diag(np.where(np.diag(information) == 0.0, BLIND**2, 0.0))
    return np.asarray(covariance + blind, dtype=float)


def covariance(jacobian: Array, residual: Array, space: ParameterSpace) -> Array:
    """Return the covariance (k, k) of a fit whose residual may be correlated and uneven.

    Source: White, Econometrica 48 (1980) 817, with blocks in place of samples.
    """
    variance = max(float(np.mean(residual**2)), np.finfo(float).tiny)
    inverse = inverse_information(jacobian, variance, space)
    scores = jacobian * residual[:, np.newaxis] / variance
    blocks = np.array([block.sum(axis=0) for block in np.array_split(scores, BLOCKS)])
    factor = BLOCKS / (BLOCKS - jacobian.shape[1])
    information = factor * blocks.T @ blocks + np.diag(_prior_information(space))
    return _with_blind(inverse @ information @ inverse, information)


def _prior_information(space: ParameterSpace) -> Array:
    """Return the inverse variances (k,) of the priors, 0 where there is none."""
    return np.asarray((1.0 / space.prior_deviation) ** 2)
