"""Static friction and Stribeck velocity from the friction curve, with profile likelihoods.

    friction(v) = F_c + (F_s - F_c) exp(-(v / v_s)^delta) + b v

For each Stribeck velocity and exponent the rest follows by linear least squares; an interval holds
all values with which some other values explain the curve.
"""

from dataclasses import dataclass

import numpy as np

from stickslip.servo.measurement import Array

EXPONENTS = (1.0, 2.0)
FREE = 4  # parameters
VELOCITIES, RISES = 400, 400  # points of the grids
BELOW = 0.2  # least Stribeck velocity, over the lowest speed
LARGEST = 4.0  # rise of friction towards rest, in F_c
USUAL, SPREAD = 1.2, 0.5  # F_s / F_c that is expected, and the deviation of its logarithm
STRAIGHT = 1e-3  # error of the curve, as it is straight between its knots, in friction
DEVIANCE = 3.84  # within the 95 % interval


@dataclass(frozen=True)
class Rise:
    """Rise of friction towards rest, with one exponent; value and ends of 95 % intervals (3,)."""

    F_s: tuple[float, float, float]  # [N]
    v_s: tuple[float, float, float]  # [m/s]
    deviance: float  # what the function does not explain of the curve


def rise(speed: Array, value: Array, covariance: Array, delta: float) -> Rise | None:
    """Return what a friction curve at speeds (k,) with a covariance (k, k) [N^2] shows of its rise.

    None where friction need not rise, or the curve ends before it is seen how far.
    """
    typical = float(np.median(value))
    straight = (STRAIGHT * typical) ** 2 * np.eye(len(speed))
    whiten = np.linalg.inv(np.linalg.cholesky(covariance + straight))
    rises = np.linspace(0.0, 1.0, RISES) ** 2 * LARGEST * typical
    velocities = np.geomspace(BELOW * speed[0], speed[-1], VELOCITIES)
    line = whiten @ np.column_stack([np.ones_like(speed), speed])
    target = whiten @ value
    shapes = whiten @ np.exp(-((speed[:, np.newaxis] / velocities) ** delta))
    basis, solve = np.linalg.qr(line)[0], np.linalg.pinv(line)
    left, across = (one - basis @ (basis.T @ one) for one in (target, shapes))
    deviance = (
        left @ left
        - 2.0 * np.outer(across.T @ left, rises)
        + np.outer(np.sum(across**2, axis=0), rises**2)
        + ((np.log1p(rises / typical) - np.log(USUAL)) / SPREAD) ** 2
    )
    static = (solve @ target)[0] + np.outer(1.0 - (solve @ shapes)[0], rises)
    least = float(deviance.min())
    # What the function does not explain counts as further error.
    inside = deviance - least <= DEVIANCE * max(1.0, least / (len(speed) - FREE))
    if inside[[0, -1]].any() or inside[:, [0, -1]].any():
        return None
    inside[1:-1] |= inside[2:] | inside[:-2]  # the true ends lie between points of the grid
    best = np.unravel_index(np.argmin(deviance), deviance.shape)
    found = velocities[inside.any(axis=1)]
    return Rise(
        (float(static[best]), float(static[inside].min()), float(static[inside].max())),
        (float(velocities[best[0]]), float(found[0]), float(found[-1])),
        least,
    )
