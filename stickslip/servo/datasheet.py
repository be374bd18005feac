"""Prior knowledge of the axis, and the specification of its loop."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from numbers import Real

from stickslip.errors import UsageError
from stickslip.servo.axis import Axis
from stickslip.servo.specification import LoopSpecification
from stickslip.storage.codec import entry


@dataclass(frozen=True)
class Datasheet:
    """From the data sheets of motor, amplifier, encoder and controller.

    Attributes
    ----------
    mass : moving mass, approximate [kg]
    peak_force : of the motor [N], Table 1
    tau_i : time constant of the amplifier's current loop [s]
    encoder_step : resolution of the encoder [m]
    force_noise : standard deviation of the measured motor force [N]
    encoder_noise : that of the position beside the steps [m]

    Raises
    ------
    UsageError
        When mass, peak_force or encoder_step is not a finite number above 0.
    """

    mass: float = field(default=5.5, metadata=entry(stored=False))
    peak_force: float = field(default=205.0, metadata=entry("N"))
    tau_i: float = field(default=1e-4, metadata=entry("s"))
    encoder_step: float = field(default=4e-7, metadata=entry("m"))
    force_noise: float = field(default=0.05, metadata=entry(stored=False))
    encoder_noise: float = field(default=0.0, metadata=entry("m"))

    def __post_init__(self) -> None:
        for name in ("mass", "peak_force", "encoder_step"):
            value = getattr(self, name)
            if not (isinstance(value, Real) and 0.0 < float(value) < math.inf):
                raise UsageError(f"datasheet.{name} = {value}: expected a finite number above 0")

    def axis(self, m: float, b: float) -> Axis:
        """Return the axis without friction, for a mass [kg] and viscous friction [N s/m]."""
        return Axis(m, b, self.tau_i)


LOOP = LoopSpecification(bandwidth=125.0, phase_margin=50.0, T_s=5e-4, tau_f=5e-4)
"""The velocity loop. How it was calibrated to Table 4: docs/decisions/0003-calibration.md."""
