"""Whether a log shows a force of position: the weight of an arm, cogging, a constant weight."""

from stickslip.thresholds import Threshold

SHARE = Threshold(0.01, "decision 142: 0.2 and above where there is one, 0.006 at most where not")
"""Root mean square over the travel of a term, over friction, below which it is left in friction."""
CERTAIN = Threshold(6.0, "decision 142")
"""The same in standard errors, in each of the eight regressions."""
SIMPLER = Threshold(0.7, "decision 142")
"""Mean square that a further term, or a longer pitch, leaves, over that without it, above which it
is not considered."""
HELD = Threshold(
    0.1, "decision 176: asymmetry of friction looks like up to 0.09 of it on 40 drives"
)
"""Constant force over friction from which on an observer leaves it to the controller."""
FALLS = Threshold(1.0, "an axis that friction holds at rest needs no force")
"""Constant force over friction from which on it is a weight."""
