"""Whether sliding motion gives a friction curve, and whether it outweighs the fit of a law."""

from stickslip.thresholds import Threshold

ROWS = Threshold(300, "decision 66")
"""Rows behind the low-pass in which the drive slides, fewer than which give no curve."""
CERTAIN = Threshold(
    6.0, "decision 66: 14 and above on three drives with ripple, at most 4 on seven"
)
"""Force that no law has, in standard errors, above which the drive has it."""
VARIES = Threshold(5e-3, "decision 66")
"""The same as a share of friction, above which the force decides instead of the simulated loop."""
CONTRADICTED = Threshold(1.5, "decision 82")
"""Distance of a law from the curve, in half-widths of that, above which the curve decides."""
NEGATIVE = Threshold(2.0, "real-logs: 4 and 15 in presliding, 0.1 and 0.3 while sliding")
"""Negative mass of a straight line, in standard errors, from which on no value is identifiable."""
