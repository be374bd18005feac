"""Whether the logged force is that which moved the drive, or was limited, filtered or cut."""

from stickslip.thresholds import Threshold

LIMITED = Threshold(0.25, "docs/measurements/guards.md: 0.01 before a limit, at least 0.94 without")
"""Share of the unexplained force that a limit must leave at most to be the force's."""
AT_LIMIT = Threshold(0.02)
"""Relative distance from its extreme up to which a force is at a limit, where none is stated."""
PILED = Threshold(0.005)
"""Share of the samples at the largest force below which nothing was cut off."""
BEYOND = Threshold(0.03)
"""Force that the motion shows beyond a limit, relative, below which nothing was cut off."""
EXACT = Threshold(0.005)
"""Unexplained share of the force up to which no low-pass is looked for."""
LAGGED = Threshold(0.35)
"""Share of the unexplained force that a low-pass must leave at most to be that of the force."""
LAGGED_ALIKE = Threshold(0.7)
"""The same, of what it leaves on motion and force alike, as it smooths coarse steps, too."""
ATTENUATED = Threshold(0.02)
"""Relative change of the mass by a low-pass below which the low-pass does not matter."""
AT_STATED = Threshold(0.995)
"""Share of a stated limit from which on a force is at it."""
PLATEAU = Threshold(3, unit="samples")
"""Duration at an extreme from which on it may be a limit."""
DEMANDED = Threshold(0.05, "0 on a loop without a limit, where its force stays equal")
"""Share of the extreme by which more force is asked for, above which it is a limit."""
SELDOM = Threshold(0.002)
"""Share of the samples at a limit that is not stated, up to which it is not reported."""
EXCEEDED = Threshold(1.05)
"""Largest force over the stated limit above which it is in another unit or from before it."""
LOST_ROWS = Threshold(5, "docs/measurements/guards.md: 400 with 2 % of the rows lost, 0 without")
"""Steps of the position that are multiples of their neighbours from which on rows are lost."""
