"""At which rate the inverse model compares forces."""

from stickslip.thresholds import Threshold

FASTEST = Threshold(
    5000.0,
    "masses beside Coulomb friction in three quiet logs at 10 kHz: 0.1 to 0.3 % off at 5 kHz, "
    "0.5 to 1.5 % at 2.5 kHz, 0.1 to 3.1 % at 10 kHz",
    unit="Hz",
)
"""Rate of the rows to which a log that is sampled faster is averaged, about."""
NOISE = Threshold(
    5e-3,
    "fitted masses: 0.22 of the true one with 3.6, 0.69 with 0.4, 0.89 with 0.08, 0.99 with 0.007; "
    "with 0.003 at 2 kHz a slower low-pass made LuGre and Dahl worse",
)
"""Variance of the acceleration by encoder noise, over that of the motion, above which a row takes
more samples: the mass would come out too small by about that share."""
QUICK = Threshold(4.0, "decision 179")
"""Cut-off of the low-pass over the usual one where reversals are too fast for the sample rate."""
