"""Whether a signal jumps as no drive can, and whether it is a counter that restarts."""

from stickslip.thresholds import Threshold

FAR = Threshold(1.0, "decision 122: 0.22 at most on 26 sound logs")
"""Size of a jump, in the largest step between two other rows, above which it is one."""
STANDS_OUT = Threshold(10.0, "decision 122")
"""Size of a jump, in the usual deviation of the steps around it, above which it is one."""
BACK = Threshold(0.1)
"""Relative difference of jumps there and back up to which the samples between them are lost."""
EQUAL = Threshold(0.01)
"""Relative difference of jumps up to which they are of one size, that of a counter's restart."""
FEWEST = Threshold(2)
"""Jumps of one size from which on a counter restarts, if the size is that of no turn or word."""
