"""Units in which any drive looks like a common one: forces of some N, speeds of some cm/s.

The FMUs' integrators have absolute tolerances and their parameters ranges, made for linear axes; a
small rotary drive has a torque of 0.01 N m and a speed of 100 rad/s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stickslip.catalog.parameters import force_and_length_of
from stickslip.identification.criteria.motion import position_of
from stickslip.logs import Recording
from stickslip.servo.measurement import Array

FORCES = (0.3, 1e4)  # root mean square that needs no scale [N]
SPEEDS = (2e-3, 2.0)  # top speed that needs none [m/s]
FORCE, SPEED = 10.0, 0.05  # what others are brought near to

_LENGTHS = {"position", "velocity", "position_command", "velocity_command", "added_velocity"}
_FORCES = {"force", "friction", "force_command", "added_force"}
_MEMORY = {"F_held", "F_fading"}  # initial state of the controller [N]


@dataclass(frozen=True)
class Scale:
    """Scaled = SI times these factors, which are powers of ten."""

    # factors
    force: float = 1.0
    length: float = 1.0

    def of(self, name: str) -> float:
        """Return the factor of a parameter or gain."""
        force, length = (1, 0) if name in _MEMORY else force_and_length_of(name)
        return self.force**force * self.length**length

    def values(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return SI values by name, scaled."""
        return {name: value * self.of(name) for name, value in values.items()}

    def restored(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return scaled values by name in SI."""
        return {name: value / self.of(name) for name, value in values.items()}

    def recording(self, recording: Recording) -> Recording:
        """Return a recording, scaled."""
        factors = dict.fromkeys(_LENGTHS, self.length) | dict.fromkeys(_FORCES, self.force)
        signals: dict[str, Array | None] = {
            name: getattr(recording, name) * factor
            for name, factor in factors.items()
            if getattr(recording, name) is not None
        }
        step = recording.encoder_step * self.length
        return replace(recording, **signals, encoder_step=step)  # type: ignore[arg-type]


SI = Scale()  # no scale


def recording_scale(recording: Recording) -> Scale:
    """Return the scale that suits a recording; none where no force was logged."""
    velocity = np.diff(position_of(recording)) / recording.T_s
    forces = (recording.force, recording.friction, recording.force_command)
    force = next((signal for signal in forces if signal is not None), None)
    if force is None:  # the controller's gains will tell
        return SI
    return scale_of(force, velocity)


def scale_of(force: Array, velocity: Array) -> Scale:
    """Return the scale that suits a force (n,) [N] and a velocity (n,) [m/s]."""
    size = float(np.sqrt(np.mean(force**2)))
    top = float(np.quantile(np.abs(velocity), 0.99))
    return Scale(_power(size, FORCES, FORCE), _power(top, SPEEDS, SPEED))


def _power(size: float, bearable: tuple[float, float], wanted: float) -> float:
    low, high = bearable
    if size <= 0.0 or low <= size <= high:
        return 1.0
    return float(10.0 ** np.round(np.log10(wanted / size)))
