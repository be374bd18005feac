"""The signals of an estimation that the figures draw, and the units in which they read best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.catalog.parameters import unit_of
from stickslip.identification.criteria.inverse_model import EDGE, SHARE
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.criteria.output_error import OutputError
from stickslip.identification.estimation import Estimation
from stickslip.logs import Motion
from stickslip.presentation.quantity import unit
from stickslip.servo.measurement import Array, derivative
from stickslip.servo.stribeck_curve import level

FULLY_BENT = 5.0
"""Deflections F_s / sigma_0 after which bristles follow the Stribeck curve, nearly."""


@dataclass(frozen=True)
class Parts:
    """What the inverse model compares, without the ends that its low-pass spoils.

    Attributes
    ----------
    t : (k,) [s]
    position : (k,) [m]
    velocity : (k,) low-passed [m/s]
    measured, predicted : (k,) force [N]
    rest : (k,) the part of both that is not friction: inertia and offset [N]
    """

    t: Array
    position: Array
    velocity: Array
    measured: Array
    predicted: Array
    rest: Array

    @property
    def difference(self) -> Array:
        """Measured less predicted force (k,) [N]."""
        return self.measured - self.predicted


def parts(estimation: Estimation) -> Parts:
    """Return the signals of the inverse model."""
    figures, recording = estimation.figures, estimation.recording
    v = figures.velocity_recorded
    n = len(figures.t)
    edge = min(int(EDGE / SHARE) + 1, n // 10)
    used = slice(edge, n - edge)
    m = estimation.parameters["m"] if "m" in estimation.known else 0.0
    rest = m * derivative(v, recording.T_s) + estimation.parameters["F_0"]
    signals = (figures.t, position_of(recording), v, figures.measured, figures.predicted, rest)
    return Parts(*(np.asarray(signal[used]) for signal in signals))


@dataclass(frozen=True)
class Residual:
    """What the learned drive leaves of a recording.

    Attributes
    ----------
    t, position, velocity : (n,) [s], [m], [m/s]
    values : (n,) [N], or [m] where the loop was simulated
    scale : in which the values read best
    what : ``Force``, ``Friction``, ``Torque``, ``Position`` or ``Angle``
    """

    t: Array
    position: Array
    velocity: Array
    values: Array
    scale: Scale
    what: str


def simulated_position(estimation: Estimation) -> Array | None:
    """Return the position (n,) in the simulated loop; None where it was not the criterion."""
    loop = estimation.criterion == OutputError.name
    return estimation.figures.simulated if loop else None


def residual(estimation: Estimation) -> Residual:
    """Return recorded less simulated position, or, of the inverse model, less predicted force."""
    recording, simulated = estimation.recording, simulated_position(estimation)
    place, push = (word.capitalize() for word in WORDS[recording.motion])
    if simulated is None:
        of = parts(estimation)
        scale = force_scale(recording.motion, of.difference)
        what = "Friction" if measures_friction(estimation) else push
        return Residual(of.t, of.position, of.velocity, of.difference, scale=scale, what=what)
    position, v = position_of(recording), estimation.figures.velocity_recorded
    left = position - simulated
    scale = position_scale(recording.motion, left)
    return Residual(recording.t, position, v, left, scale=scale, what=place)


def sliding(estimation: Estimation, signals: Parts) -> NDArray[np.bool_]:
    """Return where (k,) the displacement since the last reversal has bent the bristles fully."""
    v = signals.velocity
    path = np.cumsum(np.abs(v)) * estimation.recording.T_s
    turns = np.append(True, np.sign(v[1:]) != np.sign(v[:-1]))
    since = path - np.maximum.accumulate(np.where(turns, path, 0.0))
    p = estimation.parameters
    stiffness = p.get("sigma_0", np.inf)
    return np.asarray(since > FULLY_BENT * max(p.get("F_s", 0.0), p["F_c"]) / stiffness)


def measures_friction(estimation: Estimation) -> bool:
    """Tell whether friction itself was measured, not the motor's force."""
    return "m" not in estimation.known


def steady_name(estimation: Estimation) -> str:
    """Return the name of the law's friction at constant velocities."""
    stribeck = estimation.fit.space.law.steady == "stribeck"
    return "Stribeck curve" if stribeck else "Coulomb friction"


def steady_friction(estimation: Estimation, v: Array) -> Array:
    """Return friction (k,) [N] at constant velocities (k,) [m/s], viscous friction with it.

    Source
    ------
    Equations (4) and (5) of the paper.
    """
    p = estimation.parameters
    b = p["b"] if "b" in estimation.known else 0.0
    return np.asarray(np.sign(v) * level(p, v) + b * v)


COLUMNS = 700
"""More than a printed page's width resolves."""


def thinned(t: Array, signal: Array, columns: int = COLUMNS) -> tuple[Array, Array]:
    """Return the least and the largest value of each stretch of time, in their order.

    Parameters
    ----------
    t, signal : (n,) of any length
    columns : so many stretches; a signal of at most two values each stays as it is

    Returns
    -------
    two arrays of at most 2 columns values, which draw the same line
    """
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
SLACK = 0.999
"""A size of 0.9995 mm still counts as one of 1 mm."""


@dataclass(frozen=True)
class Scale:
    """A value in SI units times ``factor`` is one in ``unit``."""

    factor: float
    unit: str

    @classmethod
    def of(cls, size: float, unit: str) -> Scale:
        """Return the prefix with which a size reads as 1 or more.

        Parameters
        ----------
        size : of what is shown, in SI units
        unit : the SI unit, as it is printed
        """
        fitting = (prefix for prefix in PREFIXES if SLACK * prefix <= size)
        prefix = next(fitting, min(PREFIXES)) if size > 0.0 else 1.0
        return cls(1.0 / prefix, PREFIXES[prefix] + unit)


def position_scale(motion: Motion, signal: Array) -> Scale:
    """Return the scale for positions (n,) [m]."""
    largest = _largest(signal)
    if motion == "linear":
        largest = min(largest, 0.999)  # a metre of travel reads as 1000 mm
    return Scale.of(largest, POSITIONS[motion])


def velocity_scale(motion: Motion, signal: Array) -> Scale:
    """Return the scale for velocities (n,) [m/s]."""
    scale = position_scale(motion, signal)
    return Scale(scale.factor, f"{scale.unit}/s")


def force_scale(motion: Motion, signal: Array) -> Scale:
    """Return the scale for forces (n,) [N]."""
    printed = unit(unit_of("F_c", rotary=motion == "rotary"))
    return Scale.of(_largest(signal), printed)


def parameter_scale(name: str, value: float, motion: Motion, *, prefixed: bool = False) -> Scale:
    """Return the scale for a parameter: velocities in mm/s, others in SI units or prefixed."""
    given = unit_of(name, rotary=motion == "rotary")
    if given in ("m/s", "rad/s"):
        return Scale.of(min(10.0 * value, 0.999), given)
    return Scale.of(value, unit(given)) if prefixed and given != "1" else Scale(1.0, unit(given))


def from_start(position: Array) -> Array:
    """Return positions (n,) as they are, or from the first on where they are far from 0."""
    far = _largest(position) > 3.0 * float(np.ptp(position))
    return position - position[0] if far else position


def _largest(signal: Array) -> float:
    return float(np.max(np.abs(signal), initial=0.0))
