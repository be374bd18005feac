"""Which compensator is recommended: feedforward, observer, both or none."""

from stickslip.thresholds import Threshold

SIMPLER = Threshold(0.05, "decision 78")
"""Relative difference of mean error ratios up to which the simpler compensator is taken."""
SENSITIVITY = Threshold(2.2, "decision 63")
"""Largest peak sensitivity of the loop with an observer, at all masses; above it there is none."""
WORTHWHILE = Threshold(0.9)
"""Error that reversals of friction leave with an observer, relative to none; above it there is no
observer."""
HIDDEN = Threshold(0.7)
"""The same ratio above which an encoder is coarse enough to hide friction in the whole error: the
observer is then designed for the error of reversals alone."""
