"""Least squares over the coordinates of the unknowns, with a covariance that knows correlation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from scipy.optimize import least_squares

from stickslip.identification.criteria.unknowns import (
    NAMES,
    Unknowns,
    Values,
)
from stickslip.servo.measurement import Array

STEP = 1e-3  # of a coordinate, for differences
BLOCKS = 100
"""The recording is cut into so many blocks, whose sums of scores are taken to be independent."""
ROUNDS = 30


T = TypeVar("T")
R = TypeVar("R")


class Judge(Protocol):
    """Compares values with a recording."""

    name: str
    used: slice

    def residual(self, values: Values) -> Array:
        """Return what values leave unexplained (k,)."""

    def each(self, function: Callable[[T], R], items: Iterable[T]) -> list[R]:
        """Apply a function that asks for residuals to every item, perhaps side by side."""


@dataclass(frozen=True)
class Fit:
    """Where the sum of squares is least.

    Attributes
    ----------
    unknowns : give the coordinates their meaning
    q : (9,) coordinates
    residual : (k,) in the judge's unit
    jacobian : (k, 9) of the residual
    covariance : (9, 9) of q
    noise : mean square of the residual that counts as noise
    """

    unknowns: Unknowns
    q: Array
    residual: Array
    jacobian: Array
    covariance: Array
    noise: float

    @property
    def parameters(self) -> dict[str, float]:
        """The values by name, in SI units."""
        return self.unknowns.values(self.q)

    @property
    def variance(self) -> float:
        """Mean square of the residual."""
        return float(np.mean(self.residual**2))

    def shift(self, residual: Array) -> Array:
        """Return by how much q would move if this (k,) were added to the residual."""
        return -self._inverse() @ (self.jacobian.T @ residual) / self.noise

    def step(self) -> Array:
        """Return the Gauss step (9,) from here towards the least sum of squares."""
        u = self.unknowns
        pull = np.where(np.isfinite(u.doubt), (self.q - u.expected) / u.doubt**2, 0.0)
        return self.shift(self.residual) - self._inverse() @ pull

    def _inverse(self) -> Array:
        return inverse_information(self.jacobian, self.noise, self.unknowns)

    def errors(self) -> dict[str, float]:
        """Return the standard errors of the values by name, in SI units."""
        return value_errors(self.unknowns, self.q, self.covariance)


def value_errors(unknowns: Unknowns, q: Array, covariance: Array) -> dict[str, float]:
    """Return standard errors by name [SI] from a covariance (9, 9) of coordinates."""
    slopes = unknowns.slopes(q)
    spread = np.sqrt(np.maximum(np.diag(slopes @ covariance @ slopes.T), 0.0))
    return dict(zip(NAMES, spread.tolist(), strict=True))


def fit(judge: Judge, unknowns: Unknowns, start: Array) -> Fit:
    """Minimise residual and surprise from coordinates (9,) on.

    The residual is counted in its own standard deviation, so that what is expected weighs as one
    more measurement each; the deviation follows the fit in two passes.
    """
    q = np.clip(start, unknowns.lower + 1e-9, unknowns.upper - 1e-9)
    deviation = _deviation(judge.residual(unknowns.values(q)))
    for _ in range(2):
        target = _Target(judge, unknowns, deviation)
        found = least_squares(
            target,
            q,
            jac=target.jacobian,
            bounds=(unknowns.lower, unknowns.upper),
            x_scale="jac",
            max_nfev=ROUNDS,
            xtol=1e-6,
            ftol=1e-7,
        )
        q = np.clip(found.x, unknowns.lower + 1e-9, unknowns.upper - 1e-9)
        k = len(found.fun) - len(unknowns.surprise(q))
        residual = found.fun[:k] * deviation
        jacobian = np.asarray(found.jac)[:k] * deviation
        before, deviation = deviation, _deviation(residual)
        if deviation > 0.9 * before:
            break
    spread = covariance(jacobian, residual, unknowns)
    return Fit(unknowns, q, residual, jacobian, spread, float(np.mean(residual**2)))


def linearised(judge: Judge, unknowns: Unknowns, q: Array, noise: float) -> Fit:
    """Return residual and Jacobian at coordinates (9,), for a residual of that mean square."""

    def residual(x: Array) -> Array:
        return judge.residual(unknowns.values(x))

    middle, *moved = judge.each(residual, [q, *_moved(q, unknowns)])
    jacobian = _slopes(middle, moved, q, unknowns)
    spread = inverse_information(jacobian, noise, unknowns)
    return Fit(unknowns, q, middle, jacobian, spread, noise)


class _Target:
    """What least squares makes small: the residual in its deviation, and the surprise."""

    def __init__(self, judge: Judge, unknowns: Unknowns, deviation: float) -> None:
        self._judge, self._unknowns, self._deviation = judge, unknowns, deviation
        self._q, self._value = np.empty(0), np.empty(0)

    def __call__(self, q: Array) -> Array:
        self._q, self._value = q.copy(), self._at(q)
        return self._value

    def jacobian(self, q: Array) -> Array:
        """Return the Jacobian at coordinates (9,), where the value is known mostly."""
        middle = self._value if np.array_equal(self._q, q) else self(q)
        moved = self._judge.each(self._at, _moved(q, self._unknowns))
        return _slopes(middle, moved, q, self._unknowns)

    def _at(self, q: Array) -> Array:
        residual = self._judge.residual(self._unknowns.values(q))
        return np.append(residual / self._deviation, self._unknowns.surprise(q))


def _moved(q: Array, unknowns: Unknowns) -> Array:
    """Return coordinates (9, 9), in each row another one moved for a difference."""
    return q + np.diag(_steps(q, unknowns))


def _slopes(middle: Array, moved: list[Array], q: Array, unknowns: Unknowns) -> Array:
    """Return the Jacobian (k, 9) of what is (k,) in the middle and with each coordinate moved."""
    return (np.column_stack(moved) - middle[:, np.newaxis]) / _steps(q, unknowns)


def _steps(q: Array, unknowns: Unknowns) -> Array:
    return np.where(q + STEP <= unknowns.upper, STEP, -STEP)


def inverse_information(jacobian: Array, variance: float, unknowns: Unknowns) -> Array:
    """Return (J'J / variance + expectation)^-1, (9, 9)."""
    weight = np.where(np.isfinite(unknowns.doubt), 1.0 / unknowns.doubt, 0.0) ** 2
    information = jacobian.T @ jacobian / variance + np.diag(weight)
    return np.asarray(np.linalg.pinv(information, hermitian=True), dtype=float)


def covariance(jacobian: Array, residual: Array, unknowns: Unknowns) -> Array:
    """Return the covariance (9, 9) of a fit whose residual may be correlated and uneven.

    What was expected counts as independent measurements.

    Source
    ------
    White, Econometrica 48 (1980) 817, with blocks in place of samples.
    """
    variance = max(float(np.mean(residual**2)), np.finfo(float).tiny)
    inverse = inverse_information(jacobian, variance, unknowns)
    scores = jacobian * residual[:, np.newaxis] / variance
    blocks = np.array([block.sum(axis=0) for block in np.array_split(scores, BLOCKS)])
    weight = np.where(np.isfinite(unknowns.doubt), 1.0 / unknowns.doubt, 0.0) ** 2
    factor = BLOCKS / (BLOCKS - jacobian.shape[1])
    return np.asarray(inverse @ (factor * blocks.T @ blocks + np.diag(weight)) @ inverse)


def _deviation(residual: Array) -> float:
    return max(float(np.sqrt(np.mean(residual**2))), 1e-300)
