"""The signals of an estimation that the figures draw."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.identification.criteria.known_loop import OutputError
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.estimation import Estimation
from stickslip.servo.measurement import Array, derivative, level

FULLY_BENT = 5.0  # Deflections F_s / sigma_0 after which bristles follow the Stribeck curve, nearly


@dataclass(frozen=True)
class Parts:
    """What the inverse model compares, without the ends that its low-pass spoils."""

    t: Array  # (k,) [s]
    position: Array  # (k,) [m]
    velocity: Array  # (k,) low-passed [m/s]
    # (k,) force [N]
    measured: Array
    predicted: Array
    rest: Array  # (k,) the part of both that is not friction: inertia and offset [N]

    @property
    def difference(self) -> Array:
        """Measured less predicted force (k,) [N]."""
        return self.measured - self.predicted


def parts(estimation: Estimation) -> Parts:
    """Return the signals of the inverse model."""
    figures, recording = estimation.figures, estimation.recording
    v = figures.velocity_recorded
    m = estimation.parameters["m"] if "m" in estimation.known else 0.0
    rest = m * derivative(v, recording.T_s) + estimation.parameters["F_0"]
    signals = (figures.t, position_of(recording), v, figures.measured, figures.predicted, rest)
    return Parts(*(np.asarray(signal[figures.used]) for signal in signals))


def simulated_position(estimation: Estimation) -> Array | None:
    """Return the position (n,) in the simulated loop; None where it was not the criterion."""
    loop = estimation.criterion == OutputError.name
    return estimation.figures.simulated if loop else None


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
    """Return friction (k,) [N] at velocities (k,) [m/s]: Equations (4) and (5)."""
    p = estimation.parameters
    b = p["b"] if "b" in estimation.known else 0.0
    return np.asarray(np.sign(v) * level(p, v) + b * v)
