"""What a velocity loop is designed for."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.servo.axis import check, check_numbers

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
