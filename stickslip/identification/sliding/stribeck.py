"""Static friction and Stribeck velocity from the friction curve, with profile likelihoods.

    friction(v) = F_c + (F_s - F_c) exp(-(v / v_s)^delta) + b v

For each Stribeck velocity and exponent the rest follows by linear least squares; an interval holds
all values with which some other values explain the curve. The exponent is not known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.servo.measurement import Array

EXPONENTS = (1.0, 2.0)
VELOCITIES, RISES = 120, 160  # points of the grids
BELOW, ABOVE = 0.2, 1.0  # their Stribeck velocities, over the lowest and the highest speed
LARGEST = 4.0  # rise of friction towards rest, in F_c
DEVIANCE = 3.84  # within the 95 % interval


@dataclass(frozen=True)
class Rise:
    """Rise of friction towards rest, each with value and 95 % interval (3,) in SI units."""

    F_s: tuple[float, float, float]
    v_s: tuple[float, float, float]


def rise(speed: Array, value: Array, covariance: Array) -> Rise | None:
    """Return what a friction curve at speeds (k,) with a covariance (k, k) [N^2] shows of its rise.

    None where friction need not rise, or the curve ends before it is seen how far.
    """
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    typical = float(np.median(value))
    rises = np.linspace(0.0, LARGEST, RISES + 1) ** 2 / LARGEST * typical
    velocities = np.geomspace(BELOW * speed[0], ABOVE * speed[-1], VELOCITIES)
    line = whiten @ np.column_stack([np.ones_like(speed), speed])
    basis, _ = np.linalg.qr(line)
    solve = np.linalg.pinv(line)

    def rest(y: Array) -> Array:
        return y - basis @ (basis.T @ y)

    target = whiten @ value
    left = rest(target)
    deviance = np.empty((len(EXPONENTS), VELOCITIES, RISES + 1))
    coulomb = np.empty_like(deviance)
    for i, delta in enumerate(EXPONENTS):
        shapes = whiten @ np.exp(-((speed[:, np.newaxis] / velocities) ** delta))
        for j, shape in enumerate(shapes.T):
            across = rest(shape)
            deviance[i, j] = (
                left @ left - 2.0 * rises * (across @ left) + rises**2 * (across @ across)
            )
            coulomb[i, j] = (solve @ target)[0] - rises * (solve @ shape)[0]
    # What the function does not explain counts as further error.
    free = max(1, len(speed) - 4)
    deviance = (deviance - deviance.min()) / max(1.0, float(deviance.min()) / free)
    inside = (deviance <= DEVIANCE) & (coulomb > 0.0)
    best = np.unravel_index(np.argmin(np.where(inside, deviance, np.inf)), deviance.shape)
    static = coulomb + rises
    found = velocities[inside.any(axis=(0, 2))]
    at_bound = bool(inside[:, [0, -1]].any()) or bool(inside[:, :, [0, -1]].any())
    if at_bound:
        return None
    return Rise(
        (float(static[best]), float(static[inside].min()), float(static[inside].max())),
        (float(velocities[best[1]]), float(found[0]), float(found[-1])),
    )
