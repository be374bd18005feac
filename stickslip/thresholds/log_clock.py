"""Whether the times of a log are repaired, or the log is cut or refused."""

from stickslip.thresholds import Threshold

FILLED = Threshold(5, unit="samples")
"""Missing samples in a row above which the log is cut there, or a slower channel is refused."""
EVEN = Threshold(0.01, "decision 24", unit="samples")
"""Deviation from an even grid up to which it is ignored."""
UNEVEN = Threshold(0.1, unit="samples")
"""RMS of that deviation above which there is a warning."""
ROUNDED = Threshold(1.1, "decision 122")
"""Deviation from a regular clock, in steps of the clock, up to which it is rounding."""
STILL = Threshold(0.25, "1 with a rounded clock")
"""Motion between rows of equal times, over that beside them, below which the log is refused."""
IN_TURN = Threshold(0.2)
"""Share of a channel's numbers that a blank follows above which it has times of its own."""
