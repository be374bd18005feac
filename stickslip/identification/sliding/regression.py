"""Linear regression with random effects, whose variances follow from the data.

A random effect is a group of regressors whose coefficients are drawn from one normal distribution
around 0. Where the data do not require a group its variance goes to 0, and it costs no precision.

Sources
-------
Patterson, Thompson, Biometrika 58 (1971) 545 (restricted likelihood);
MacKay, Neural Computation 4 (1992) 415 (the fixed-point iteration used here).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.catalog.parameters import correlation_length
from stickslip.servo.measurement import Array

ROUNDS = 16
CORRELATED = (5, 9, 12)  # rounds in which the correlation of the residual is estimated
LAGS = 400  # at which it is looked for
DEVIATIONS = (1e-4, 1.0)  # least and largest standard deviation of a random coefficient
FEW = 5  # rows of a class of noise up to which all rows give its variance


@dataclass(frozen=True)
class Regression:
    """The coefficients of a regression."""

    coefficients: Array  # (k,) the fixed ones first, then the groups in their order
    covariance: Array  # (k, k)
    places: dict[str, slice]  # where the coefficients of each group are


def regress(
    y: Array,
    fixed: Array,
    groups: Mapping[str, Array],
    classes: NDArray[np.intp],
    least: Mapping[str, float] | None = None,
) -> Regression:
    """Fit y (n,) by fixed regressors (n, f) and groups of random ones (n, j).

    Groups are scaled such that a standard deviation of 1 of their coefficients is large. In each of
    the classes (n,), from 0 on, the noise has a variance of its own. ``least`` has the least
    standard deviations of groups, from which on they are estimated.
    """
    x = np.column_stack([fixed, *groups.values()])
    edges = fixed.shape[1] + np.cumsum([0, *(group.shape[1] for group in groups.values())])
    places = {name: slice(*edges[i : i + 2]) for i, name in enumerate(groups)}
    scale = np.maximum(np.sqrt(np.mean(x**2, axis=0)), np.finfo(float).tiny)
    noise = np.full(classes.max() + 1, 1e-2 * np.var(y))
    count = np.bincount(classes, minlength=len(noise))
    members = [classes == one for one in range(len(noise))]
    products = np.array([x[rows].T @ x[rows] for rows in members])
    moments = np.array([x[rows].T @ y[rows] for rows in members])
    lowest = {name: max(DEVIATIONS[0], (least or {}).get(name, 0.0)) for name in groups}
    deviations = dict.fromkeys(groups, 0.03) | dict(least or {})
    correlation = 3.0
    for pass_ in range(ROUNDS):
        prior = 1e-12 * scale**2 / np.mean(noise)
        for name, place in places.items():
            prior[place] = 1.0 / deviations[name] ** 2
        weights = 1.0 / (noise * correlation)
        information = np.tensordot(weights, products, 1) + np.diag(prior)
        # Regressors differ by orders of magnitude; the inverse is taken of those of like size.
        size = np.sqrt(np.diag(information))
        covariance = np.linalg.pinv(information / np.outer(size, size), hermitian=True)
        covariance /= np.outer(size, size)
        c = covariance @ (weights @ moments)
        rest = y - x @ c
        used = np.tensordot(products, covariance) / noise
        squares = np.bincount(classes, rest**2, len(noise))
        few = count - used <= FEW
        noise = np.where(few, np.mean(rest**2), squares / np.where(few, 1.0, count - used))
        noise = np.maximum(noise, 1e-12 * np.var(y))
        if pass_ in CORRELATED:
            correlation = correlation_length(rest / np.sqrt(noise[classes]), LAGS)
        for name, place in places.items():
            effective = c[place].size - np.sum(np.diag(covariance)[place]) * prior[place.start]
            found = np.sqrt(np.sum(c[place] ** 2) / max(effective, 1e-3))
            deviations[name] = float(np.clip(found, lowest[name], DEVIATIONS[1]))
    return Regression(c, covariance, places)
