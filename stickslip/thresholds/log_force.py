"""Whether the logged force is that which moved the drive, or was limited, filtered or cut."""

from stickslip.thresholds import Threshold

LIMITED = Threshold(0.25, "decision 39")
"""Share of the unexplained force that a limit must leave at most to be the force's."""
AT_LIMIT = Threshold(0.02)
"""Relative distance from its extreme up to which a force is at a limit, where none is stated."""
PILED = Threshold(0.005)
"""Share of the samples at the largest force below which that force is not one that was cut off."""
BEYOND = Threshold(0.03)
"""Force at a limit that the motion shows beyond it, relative, below which nothing was cut off."""
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
DEMANDED = Threshold(0.05)
"""Share of the extreme by which the loop asks for more force, above which it is a limit; a loop
without one has 0 where its force stays equal."""
SELDOM = Threshold(0.002)
"""Share of the samples at a limit that is not stated, up to which it is not reported."""
EXCEEDED = Threshold(1.05)
"""Largest force over the stated limit above which the force has another unit or was logged before
the limit."""
LOST_ROWS = Threshold(5)
"""Steps of the position that are multiples of their neighbours from which on rows are lost."""
