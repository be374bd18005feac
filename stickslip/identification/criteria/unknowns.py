"""What is sought, and the coordinates in which it is sought.

Coordinates are logarithms where a value is positive, so that decades count alike, and F_s enters as
log(F_s / F_c) >= 0. All coordinates are of the order of 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stickslip.catalog.parameters import LUGRE
from stickslip.servo.measurement import Array

NAMES = (*LUGRE, "m", "b", "F_0", "delay")
"""LuGre's five, mass and viscous friction, a constant force against the motor's [N], and by how
much the force acts later than it was logged or commanded [s]."""

FRICTION = (*LUGRE, "delta")
"""Parameters of the compensator FMU."""
SOUGHT = (*LUGRE, "m", "b")
LEVEL = 1e-6
"""Upper bound of log(F_s / F_c) where friction is taken to be level."""
LOGS = 6  # so many coordinates, from the first on, are logarithms

Values = Mapping[str, float]


@dataclass(frozen=True)
class Unknowns:
    """Coordinates q (9,) of values by name.

    Attributes
    ----------
    b_unit, force_unit, time_unit : what b [N s/m], F_0 [N] and delay [s] are counted in
    expected : (9,) where a coordinate lies if the recording says nothing of it
    doubt : (9,) standard deviation of that expectation, infinite where there is none
    lower, upper : (9,) bounds
    delta : exponent of the Stribeck curve
    """

    b_unit: float
    force_unit: float
    time_unit: float
    expected: Array
    doubt: Array
    lower: Array
    upper: Array
    delta: float = 1.0

    def coordinates(self, values: Values) -> Array:
        """Return q (9,) of values by name."""
        logs = [values["F_s"] / values["F_c"], *(values[name] for name in NAMES[1:LOGS])]
        units = (self.b_unit, self.force_unit, self.time_unit)
        rest = [values[name] / unit for name, unit in zip(NAMES[LOGS:], units, strict=True)]
        q = np.append(np.log(logs), rest)
        return np.asarray(np.clip(q, self.lower, self.upper), dtype=float)

    def values(self, q: Array) -> dict[str, float]:
        """Return values by name and ``delta``, in SI units."""
        positive = np.exp(q[:LOGS])
        positive[0] *= positive[1]
        units = np.array([self.b_unit, self.force_unit, self.time_unit])
        values = [*positive.tolist(), *(q[LOGS:] * units).tolist()]
        return dict(zip(NAMES, values, strict=True)) | {"delta": self.delta}

    def slopes(self, q: Array) -> Array:
        """Return d value / d coordinate (9, 9)."""
        values = self.values(q)
        diagonal = [values[name] for name in NAMES[:LOGS]]
        slopes = np.diag([*diagonal, self.b_unit, self.force_unit, self.time_unit])
        slopes[0, 1] = values["F_s"]
        return slopes

    def surprise(self, q: Array) -> Array:
        """Return how far coordinates are from what is expected (k,), in standard deviations."""
        known = np.isfinite(self.doubt)
        return np.asarray(((q - self.expected) / self.doubt)[known])
