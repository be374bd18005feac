"""Whether logs that are learned together agree with each other."""

from stickslip.thresholds import Threshold

CONTRADICTS = Threshold(2.0, "decision 141")
"""Ratio of squares that the others leave with and without a log above which it contradicts them."""
MATTERS = Threshold(0.02, "decision 168")
"""RMS of what a log adds to the error of the others, over their force, below which it is left."""
EXPLAINED = Threshold(3.5, "decision 168: true ones reach 2.0, false ones begin at 6.0")
"""Error, over the force, that its own mass, friction and constant force leave of a log that
contradicts, over that of the others without it, above which it is the law that fails."""
DIFFERS = Threshold(0.15, "decision 172: 0.096 on a sound drive; 0.25 and more on altered logs")
"""Difference of its mass or friction, or of its constant force over F_c, that contradicts."""
CERTAIN = Threshold(4.0, "decision 141")
"""Difference of the constant force of a log, in its standard errors, that is taken into account."""
