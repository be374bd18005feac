"""Whether signals of a log contradict each other, and are refused until units are corrected."""

from stickslip.thresholds import Threshold

IMAGE = Threshold(0.8, "decision 38")
"""Correlation from which on one signal is the other's image, whose scales are compared."""
SURE_IMAGE = Threshold(0.98, "decision 38: 3 instead of 10 of 1,500 sound loops are refused")
"""The same for an inverted image, for a small factor of units, and for any scale of a command: the
moves of drives that stick were 0.4 of it at a correlation of up to 0.96."""
SMALL = Threshold(20.0, "decision 38")
"""Factor of units below which it takes such a correlation."""
UNLIKE = Threshold(0.3, "decision 122: other axes 0.23, drives that stick 0.74, sound logs 0.99")
"""Correlation below which two signals are not of one axis, and the log is refused."""
SHARED = Threshold(0.1, "decision 122: other axes 0.09, drives that slip a few times 0.15")
"""Share of the force like that of the motion below which they are not of one axis."""
MOVING = Threshold(0.1)
"""Share of the time in motion below which that share is not known."""
FOLLOWS = Threshold(2.0, "decision 38")
"""Ratio of a signal and its command, or its inverse, above which there is a warning."""
EQUALS = Threshold(1.25, "decision 38")
"""The same for two signals that should be equal."""
NEAR = Threshold(0.03)
"""Difference of a ratio from a factor of units, as a logarithm, up to which it is that factor."""
ROUGHLY = Threshold(0.25)
"""The same for factors above 100."""
FASTER = Threshold(200.0)
"""Samples of a controller in one of its log above which their times contradict each other."""
SLOWER = Threshold(20.0)
"""Samples of a log in one of its controller, the same."""
SLOWEST = Threshold(0.05, "decision 38", unit="s")
"""Sample period above which a time without a unit is asked about."""
STEP = Threshold(0.05)
"""Distance of a step from a multiple of the stated one above which there is a warning."""
