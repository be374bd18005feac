"""Where the cost should be lowest, by all that was seen: in its valley, and by and large.

Near its lowest point a smooth cost is a paraboloid. One fitted to the cheapest candidates so far
gives its minimum, for the price of one evaluation; as better candidates come in, the fit
closes in on it. Least squares over more points than unknowns averages what noise there is.

A round bowl has only k + 2 unknowns. Fitted to many candidates it averages small valleys as well.
"""

from __future__ import annotations

import numpy as np

from stickslip.ga.arrays import Array

RADIUS = 2.0
"""How far a step may go, in standard deviations of the points fitted to."""

LIGHTEST = 0.05
"""Weight of the most expensive point, relative to the cheapest."""


POINTS = 2
"""A quadratic is fitted to so many times as many candidates as it has coefficients."""

LARGEST = 256
"""Coefficients of the largest quadratic; beyond, products of two variables are left out."""

SAME = 0.03
"""Candidates closer than this in each gene, on [0, 1], crowd each other in the fit of a bowl."""

THINNED = 400
"""Candidates that a bowl is fitted to at most."""


def unknowns(k: int) -> int:
    """Return the number of coefficients of a quadratic in k variables."""
    full = (k + 1) * (k + 2) // 2
    return full if full <= LARGEST else 2 * k + 1


def bottom(strings: Array, costs: Array) -> Array | None:
    """Return where a quadratic through candidates (n, k), the cheapest first, is lowest, (k,).

    It is within `RADIUS` of the cheapest, and may leave [0, 1]. None while there are too few
    candidates, or all cost the same.
    """
    k = strings.shape[1]
    strings, costs = strings[: POINTS * unknowns(k)], costs[: POINTS * unknowns(k)]
    finite = np.isfinite(costs)
    strings, costs = strings[finite], costs[finite]
    if len(strings) <= unknowns(k) or costs[0] == costs[-1]:
        return None
    variance, axes = np.linalg.eigh(np.cov(strings, rowvar=False).reshape(k, k))
    if variance[-1] <= 0:
        return None
    scale = np.sqrt(np.maximum(variance, 1e-16 * variance[-1]))
    away = (strings - strings[0]) @ axes / scale  # in standard deviations along principal axes
    gradient, curvature = _fit(away, (costs - costs[0]) / (costs[-1] - costs[0]))
    return np.asarray(strings[0] + axes @ (scale * _step(gradient, curvature)))


def _fit(points: Array, costs: Array) -> tuple[Array, Array]:
    """Fit gradient (k,) and Hessian (k, k) at the origin to points (n, k) and costs (n,)."""
    k = points.shape[1]
    rows, columns = np.triu_indices(k)
    if len(rows) > unknowns(k):
        rows, columns = np.diag_indices(k)
    terms = np.hstack([np.ones((len(points), 1)), points, points[:, rows] * points[:, columns]])
    weights = np.linspace(1.0, LIGHTEST, len(points))
    fitted = np.linalg.lstsq(terms * weights[:, np.newaxis], costs * weights, rcond=None)[0]
    half = np.zeros((k, k))
    half[rows, columns] = fitted[k + 1 :]
    return np.asarray(fitted[1 : k + 1], dtype=float), half + half.T


def _step(gradient: Array, hessian: Array) -> Array:
    """Return the lowest point (k,) of the quadratic within `RADIUS`.

    Source
    ------
    Nocedal and Wright, Numerical Optimization, 2nd ed., section 4.3.
    """
    curvature, axes = np.linalg.eigh(hessian)
    slope = axes.T @ gradient
    size = float(np.abs(curvature).max()) or 1.0

    def step(shift: float) -> Array:
        return np.asarray(-slope / (curvature + shift))

    low = max(0.0, -float(curvature[0])) + 1e-9 * size
    if np.linalg.norm(step(low)) > RADIUS:
        high = low + float(np.linalg.norm(slope)) / RADIUS + size
        for _ in range(60):
            middle = (low + high) / 2
            if np.linalg.norm(step(middle)) > RADIUS:
                low = middle
            else:
                high = middle
        low = high
    return np.asarray(axes @ step(low))


def bowl(strings: Array, costs: Array) -> Array | None:
    """Return where a round bowl through candidates (n, k) in order of cost is lowest, (k,).

    Where candidates crowd, each counts less, so that the place does not depend on where most of
    them happen to be. None while there are too few candidates, or no bowl.
    """
    finite = np.isfinite(costs)
    thinned = slice(None, None, -(-int(finite.sum()) // THINNED) or 1)
    strings, costs = strings[finite][thinned], costs[finite][thinned]
    n, k = strings.shape
    if n < k + 3 or costs[0] == costs[-1]:
        return None
    middle = strings.mean(axis=0)
    away = strings - middle
    squares = np.sum(away**2, axis=1)
    apart = np.maximum(squares[:, np.newaxis] + squares - 2 * away @ away.T, 0.0)
    weights = 1 / np.sqrt(np.exp(-apart / (k * SAME**2)).sum(axis=1))
    terms = np.hstack([np.ones((n, 1)), away, squares[:, np.newaxis]])
    heights = (costs - costs[0]) / (costs[-1] - costs[0])
    fitted = np.linalg.lstsq(terms * weights[:, np.newaxis], heights * weights, rcond=None)[0]
    if not fitted[-1] > 0:
        return None
    return np.asarray(np.clip(middle - fitted[1:-1] / (2 * fitted[-1]), 0.0, 1.0))
