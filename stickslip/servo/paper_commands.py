"""The velocity commands of the paper."""

from stickslip.cosim import SineSweep, Trapezoid

TRAINING = SineSweep(frequency=(0.1, 5.0), amplitude=(0.030, 0.040), duration=10.0)
"""The training command of section 4.2 [m/s]."""

SLOW = SineSweep(frequency=(0.1, 0.5), amplitude=(0.030, 0.040), duration=10.0)
"""Reversals slower than nearly all of the training command, to compare results of it on [m/s]."""

VALIDATION = Trapezoid(height=0.040, slope=0.055, plateau=0.5, begin=0.1)
"""The trapezoid of Fig. 6(a) [m/s]."""

REGION = (0.030, 0.070)
"""The evaluated windows: from when to when after motion starts or reverses [s]."""
