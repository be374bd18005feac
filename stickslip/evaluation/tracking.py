"""How a drive follows a command, with each compensation that is compared: errors over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from stickslip.identification.criteria.motion import position_of
from stickslip.logs import Recording
from stickslip.servo.measurement import CUTOFF, Array, derivative, smoothed

NONE, FEEDFORWARD, FRICTIONLESS = "without compensator", "with compensator", "without friction"
"""Variants: no compensation, the force of the compensator, and no friction at all."""
SHARE = 1.0 / 16.0
"""Cut-off of the low-pass of measured velocities at most, as share of the sample rate."""


@dataclass(frozen=True)
class TrackingError:
    """Root mean square and largest absolute value of the errors of velocity and position."""

    # [m/s]
    velocity_rms: float
    velocity_max: float
    # [m]
    position_rms: float
    position_max: float

    @classmethod
    def of(cls, velocity: Array, position: Array) -> TrackingError:
        """Return it for errors (n,) of velocity [m/s] and position [m]."""
        return cls(*_size(velocity), *_size(position))

    def items(self) -> dict[str, float]:
        """Return the figures by name."""
        return {name: getattr(self, name) for name in TRACKING_FIGURES}


TRACKING_FIGURES = tuple(field.name for field in fields(TrackingError))
"""Names of the figures of a ``TrackingError``."""


def _size(error: Array) -> tuple[float, float]:
    return float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))


@dataclass(frozen=True)
class Tracking:
    """Simulated motion of a drive along one command."""

    t: Array  # (n,) [s]
    v_cmd: Array  # (n,) commanded velocity [m/s]
    velocity: Mapping[str, Array]  # (n,) true velocity by variant [m/s]
    position_error: Mapping[str, Array]  # (n,) true position less commanded position by variant [m]
    used: slice  # the samples that count; the first ones do not where the log began in motion
    # the loop and the command, in words
    loop: str
    command: str
    known: bool  # whether the loop is that of the log's controller
    # tracking error of the log itself, without compensation; None where the simulated loop or
    # command is another
    measured: TrackingError | None = None

    def velocity_error(self, variant: str) -> Array:
        """Return velocity less command (n,) [m/s]."""
        return self.velocity[variant] - self.v_cmd

    def errors(self) -> dict[str, TrackingError]:
        """Return the tracking errors by variant."""
        return {
            name: TrackingError.of(
                self.velocity_error(name)[self.used], self.position_error[name][self.used]
            )
            for name in self.velocity
        }

    def reduction(self, figure: str, variant: str = FEEDFORWARD) -> float:
        """Return by which share a variant makes a figure of ``TrackingError`` smaller."""
        errors = self.errors()
        without = errors[NONE].items()[figure]
        return 1.0 - errors[variant].items()[figure] / without if without > 0.0 else np.nan


def measured_velocity(position: Array, T_s: float) -> Array:
    """Return the velocity (n,) [m/s] of an encoder's positions (n,) [m], low-passed."""
    return derivative(smoothed(position, T_s, cutoff(T_s)), T_s)


def cutoff(T_s: float) -> float:
    """Return the cut-off of the low-pass of measured velocities [Hz]."""
    return min(CUTOFF, SHARE / T_s)


def measured_errors(recording: Recording, v_cmd: Array, x_cmd: Array) -> tuple[Array, Array]:
    """Return the errors (n,) of velocity [m/s] and position [m] that a log shows.

    Command and motion go through the same low-pass, which has no phase lag.

    Parameters
    ----------
    v_cmd, x_cmd : (n,) commanded velocity [m/s] and position [m]
    """
    T_s, position = recording.T_s, position_of(recording)
    velocity = measured_velocity(position, T_s)
    return velocity - smoothed(v_cmd, T_s, cutoff(T_s)), position - x_cmd
