"""The axis without friction, continuous and sampled."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import lru_cache
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import UsageError
from stickslip.fmi.errors import Fault
from stickslip.models.export.units import motion_unit
from stickslip.storage.codec import entry

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]


class ControlError(Fault, ValueError):
    """No controller meets the specification; the message says what can be reached."""


@dataclass(frozen=True)
class Axis:
    """The axis without friction: mass m [kg], viscous friction b [N s/m], current lag tau_i [s].

    For a rotary axis read rad for m, N m for N and kg m2 for kg.

    Raises
    ------
    ControlError
        When m is not positive, tau_i negative, or a number not finite.
    """

    m: float
    b: float
    tau_i: float = 0.0
    rotary: bool = False

    def __post_init__(self) -> None:
        check_numbers(self)
        check("m", self.m, self.unit("kg"), self.m > 0.0, expected="above 0")
        check("m", self.m, self.unit("kg"), 1e-18 < self.m < 1e12, expected="1e-18 to 1e12")
        check("b", self.b, self.unit("N s/m"), True, expected="a number")
        check("tau_i", self.tau_i, "s", self.tau_i >= 0.0, expected="0 or above")

    def unit(self, unit: str) -> str:
        """Return a unit of a linear axis as it is printed for this one."""
        return motion_unit(unit, rotary=self.rotary).replace(".", " ")

    def of_drive(self) -> dict[str, float | bool]:
        """Return the start values of a drive FMU on this axis; without a lag it has none."""
        lag = {"tau_i": self.tau_i} if self.tau_i else {"current_loop": False}
        return {"m": self.m, "b": self.b, **lag}

    def sampled(self, T_s: float) -> control.StateSpace:
        """Return the axis from a held command u [N] to motor force F, velocity v and position x.

        The states are the outputs. Without a lag F follows u at once: at a sample it is the command
        of the period that ends.
        """
        import control  # late, for those who start quickly

        A, B = _sampled(self, T_s)
        return control.ss(A, B, np.eye(3), 0, T_s, inputs="u", outputs=["F", "v", "x"])

    def period(self, T_s: float) -> tuple[Array, Array, Array]:
        """Return the effect of a period, from the motor force at its ends.

        (x, v, d)+ = A (x, v, d) + last F + now F+, with a held disturbing force d [N]: A (3, 3),
        last (3,), now (3,). Exact, since between samples F follows the lag.
        """
        return _period(self, T_s)


@lru_cache(maxsize=16)
def _period(axis: Axis, T_s: float) -> tuple[Array, Array, Array]:
    system = axis.sampled(T_s)
    keep, held = system.A[0, 0], system.B[[2, 1], 0]
    now = held / (1.0 - keep)
    last = system.A[[2, 1], 0] - now * keep
    A = np.eye(3)
    A[:2, :2] = system.A[np.ix_([2, 1], [2, 1])]
    free = Axis(axis.m, axis.b).sampled(T_s)
    A[:2, 2] = free.B[[2, 1], 0]
    found = A, np.append(last, 0.0), np.append(now, 0.0)
    for array in found:
        array.flags.writeable = False
    return found


def check_numbers(given: Any) -> None:
    """Raise a ControlError unless all fields of a dataclass are numbers."""
    for one in fields(given):
        if not isinstance(value := getattr(given, one.name), Real):
            raise ControlError(f"{one.name} is {value!r:.80}; expected a number")


def check(name: str, value: float, unit: str, holds: bool, expected: str) -> None:
    """Raise a ControlError unless a value is finite and a condition holds."""
    if not (holds and np.isfinite(value)):
        raise ControlError(f"{name} is {value:g} {unit}; expected {expected}")


_SLOWEST = 1e-5  # of the sample rate; below, poles in z differ from 1 by too few digits


@dataclass(frozen=True)
class LoopSpecification:
    """Requirements on the loop, and its sampling.

    Attributes
    ----------
    bandwidth : gain crossover of the open loop [Hz]
    phase_margin : at that crossover [deg]
    T_s : sample period [s]
    tau_f : time constant of the low-pass in the velocity estimate [s], 0 for none

    Raises
    ------
    ControlError
        When a number is out of its range.
    """

    bandwidth: float
    phase_margin: float
    T_s: float = 5e-4
    tau_f: float = 0.0

    def __post_init__(self) -> None:
        check_numbers(self)
        check("T_s", self.T_s, "s", self.T_s > 0.0, expected="above 0")
        check("tau_f", self.tau_f, "s", self.tau_f >= 0.0, expected="0 or above")
        inside = 0.0 < self.phase_margin < 180.0
        check("phase margin", self.phase_margin, "deg", inside, expected="between 0 and 180")
        rate = 1.0 / self.T_s
        inside = _SLOWEST * rate < self.bandwidth < 0.5 * rate
        limits = f"between {_SLOWEST * rate:g} and {0.5 * rate:g} Hz, half the sample rate"
        check("bandwidth", self.bandwidth, "Hz", inside, expected=limits)


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
    force_noise: float = field(default=0.05, metadata=entry("N"))
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


@lru_cache
def _sampled(axis: Axis, T_s: float) -> tuple[Array, Array]:
    """Return the matrices of ``Axis.sampled``, which a search of gains needs again and again."""
    import control

    m, b = axis.m, axis.b
    A = np.array([[0, 0, 0], [1 / m, -b / m, 0], [0, 1, 0]])
    B = np.array([[0], [1 / m], [0]])
    if axis.tau_i > 0.0:
        A[0, 0], B[0, 0] = -1 / axis.tau_i, 1 / axis.tau_i
        B[1, 0] = 0.0
    else:
        A[1, 0] = 0.0
    sampled = control.sample_system(control.ss(A, B, np.eye(3), 0), T_s, method="zoh")
    A, B = np.array(sampled.A), np.array(sampled.B)
    if axis.tau_i == 0.0:
        A[0, 0], B[0, 0] = 0.0, 1.0
    return A, B
