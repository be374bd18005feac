"""Whether logs that are learned together agree with each other."""

from stickslip.thresholds import Threshold

CONTRADICTS = Threshold(2.0, "decision 141")
"""Ratio of squares that the others leave with and without a log above which it contradicts them."""
DIFFERS = Threshold(0.05, "decision 141")
"""Difference of its mass or friction, or of its constant force over F_c, that is reported."""
CERTAIN = Threshold(4.0, "decision 141")
"""Difference of the constant force of a log, in its standard errors, that is taken into account."""
