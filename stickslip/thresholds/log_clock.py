"""Whether the times of a log are repaired, or the log is cut or refused."""

from stickslip.thresholds import Threshold

FILLED = Threshold(5, unit="samples")
"""Missing samples in a row up to which they are interpolated; where more are missing the log is
cut, or a slower channel is refused."""
EVEN = Threshold(0.01, unit="samples")
"""Deviation from an even grid up to which it is ignored."""
UNEVEN = Threshold(0.1, unit="samples")
"""RMS of that deviation above which there is a warning."""
ROUNDED = Threshold(1.1)
"""Deviation from a regular clock, in steps of the clock, up to which it is rounding: of one step,
and what the fit of a period adds."""
STILL = Threshold(0.25)
"""Motion between rows of equal times, over that between the rows beside them, below which the rows
are of several sources, and the log is refused; 1 with a rounded clock."""
IN_TURN = Threshold(0.2)
"""Share of a channel's numbers that a blank follows above which it has times of its own."""
