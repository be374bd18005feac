"""Which compensator is written: feedforward, observer, both or none; and whether to tune."""

from stickslip.thresholds import Threshold

SIMPLER = Threshold(0.05, "decision 78")
"""Relative difference of mean error ratios, times the largest where that is above 1, up to which
the simpler compensator is chosen."""
GAIN = Threshold(0.9, "decision 139: one of 37 drives was predicted 0.93 and had 1.05, up to 1.38")
"""Mean error ratio on the family above which a compensator is not worth its risk."""
SENSITIVITY = Threshold(2.2, "decision 63")
"""Largest peak sensitivity of the loop with an observer, at all masses; above it there is none."""
WORTHWHILE = Threshold(0.9)
"""Error of friction's reversals with an observer over that without, above which there is none."""
HIDDEN = Threshold(0.7)
"""The same ratio above which a coarse encoder hides friction, so that reversals alone count."""
OTHER_GAINS = Threshold(0.9, "docs/tuning.md: with 0.85 the true drive had 0.88")
"""Error that the best of a few other gains leaves, over that of the present loop, above which
tuning is said to promise little."""
