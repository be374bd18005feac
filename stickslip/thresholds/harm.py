"""Whether a compensator is withheld, or written with a share of its force."""

from stickslip.thresholds import Threshold

WORSE = Threshold(1.005, "decision 62")
"""Largest ratio of the error with a compensator to that without it, on each drive of the family and
each command; above it a smaller share of the force is tried, and at last none is written. The true
drive differs from all of the family, and may then be worse by one or two per cent."""
REPEATED_ABOVE = Threshold(0.9, "decision 62: single runs scatter by 5 to 10 %")
"""Ratio above which it is the mean of several runs: a single one may pass by chance."""
REPEATED_BELOW = Threshold(1.25, "decision 62: single runs scatter by 5 to 10 %")
"""Ratio below which it is the mean of several runs: a single one may fail by chance."""
RULED_OUT = Threshold(5.0, "decision 62")
"""Force error of a law over the least among the laws, above which no drive of that law is tried."""
RESERVE = Threshold(1.3, "decision 62")
"""Largest static friction of a drive on which a compensator is tried, over that in the log."""
WIDE = Threshold(2.0)
"""Value of one that is poorly identified on which a compensator is tried, over that taken."""
