"""Whether tuning on a drive goes on after a motion, or returns to the present gains."""

from stickslip.thresholds import Threshold

WORSE = Threshold(
    1.1, "docs/tuning.md: repeated motions of the simulated drive scatter by 1 to 6 %"
)
"""Error of a motion over that of the present loop in the same motion, above which it stops."""
RIPPLE = Threshold(2.0)
"""RMS of the motor force above the crossover frequency over that of the present loop, above which
the loop oscillates, unless it is below ``kept.CHATTER`` times the Coulomb friction."""
