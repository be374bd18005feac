"""Whether a delay of the logged force is reported and taken out."""

from stickslip.thresholds import Threshold

REPORTED = Threshold(2.0, unit="samples")
"""Delay from which on it is more than that of a sampled loop, and is taken out."""
EXPLAINS = Threshold(0.5, "docs/measurements/guards.md: 0.01 to 0.03 where the force is late")
"""Share of the unexplained force that a delay must leave at most to be taken out."""
KNOWN = Threshold(0.5, unit="samples")
"""Width of two standard errors of a delay above which it is called not determined."""
