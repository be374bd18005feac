"""Units in which signals and parameters read best, and signals thinned to what figures resolve."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.catalog.parameters import unit_of
from stickslip.presentation.quantity import unit
from stickslip.servo.measurement import Array

COLUMNS = 700  # More than a printed page's width resolves


def thinned(t: Array, signal: Array, columns: int = COLUMNS) -> tuple[Array, Array]:
    """Return the extremes of stretches of a signal (n,) at times (n,), which draw the same line."""
    if len(t) <= 2 * columns:
        return t, signal
    kept = []
    for stretch in np.array_split(np.arange(len(t)), columns):
        ends = (stretch[np.argmin(signal[stretch])], stretch[np.argmax(signal[stretch])])
        kept += sorted(set(ends))
    return t[kept], signal[kept]


def spread(n: int, most: int) -> NDArray[np.intp]:
    """Return at most ``most`` of n indices, evenly spaced."""
    return np.arange(0, n, max(1, -(-n // most)))


POSITIONS = {"linear": "m", "rotary": "rad"}
WORDS = {"linear": ("position", "force"), "rotary": ("angle", "torque")}
PREFIXES = {1e3: "k", 1.0: "", 1e-3: "m", 1e-6: "µ", 1e-9: "n"}
SLACK = 0.999  # A size of 0.9995 mm still counts as one of 1 mm


@dataclass(frozen=True)
class Scale:
    """A value in SI units times ``factor`` is one in ``unit``."""

    factor: float
    unit: str

    @classmethod
    def of(cls, size: float, unit: str) -> "Scale":
        """Return the prefix with which a size in an SI unit, as printed, reads as 1 or more."""
        fitting = (prefix for prefix in PREFIXES if SLACK * prefix <= size)
        prefix = next(fitting, min(PREFIXES)) if size > 0.0 else 1.0
        return cls(1.0 / prefix, PREFIXES[prefix] + unit)


def position_scale(motion: str, signal: Array | float) -> Scale:
    """Return the scale for positions (n,) [m], or for the size of one."""
    largest = _largest(signal)
    if motion == "linear":
        largest = min(largest, 0.999)  # a metre of travel reads as 1000 mm
    return Scale.of(largest, POSITIONS[motion])


def velocity_scale(motion: str, signal: Array | float) -> Scale:
    """Return the scale for velocities (n,) [m/s]."""
    scale = position_scale(motion, signal)
    return Scale(scale.factor, f"{scale.unit}/s")


def force_scale(motion: str, signal: Array | float) -> Scale:
    """Return the scale for forces (n,) [N]."""
    printed = unit(unit_of("F_c", rotary=motion == "rotary"))
    return Scale.of(_largest(signal), printed)


def parameter_scale(name: str, value: float, motion: str, *, prefixed: bool = False) -> Scale:
    """Return the scale for a parameter: velocities in mm/s, others in SI units or prefixed."""
    given = unit_of(name, rotary=motion == "rotary")
    if given in ("m/s", "rad/s"):
        return Scale.of(min(10.0 * value, 0.999), given)
    return Scale.of(value, unit(given)) if prefixed and given != "1" else Scale(1.0, unit(given))


def from_start(position: Array) -> Array:
    """Return positions (n,) as they are, or from the first on where they are far from 0."""
    far = _largest(position) > 3.0 * float(np.ptp(position))
    return position - position[0] if far else position


def _largest(signal: Array | float) -> float:
    return float(np.max(np.abs(signal), initial=0.0))
