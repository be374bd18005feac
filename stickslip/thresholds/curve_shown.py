"""Whether sliding motion gives a friction curve, and whether it outweighs the fit of a law."""

from stickslip.thresholds import Threshold

ROWS = Threshold(300, "decision 66")
"""Rows behind the low-pass in which the drive slides, fewer than which give no curve."""
CERTAIN = Threshold(
    6.0, "decision 66: 14 and above on three drives with ripple, at most 4 on seven"
)
"""Force that no law has, in standard errors, above which the drive has it."""
OFFSET = Threshold(
    2e-3, "decision 175: 3 of 10 vertical drives were up to 0.16 % off, known within 0.05"
)
"""Least half-width of the interval of the constant force, as a share of friction."""
VARIES = Threshold(5e-3, "decision 66")
"""The same as a share of friction, above which the force decides instead of the simulated loop."""
CONTRADICTED = Threshold(1.8, "decision 82: 2 to 53 where it did; a sound cascade of 8 s had 1.65")
"""Distance of a law from the curve, in half-widths of that, above which the curve decides."""
NEGATIVE = Threshold(2.0, "real-logs: 4 and 15 in presliding, 0.1 and 0.3 while sliding")
"""Negative mass of a straight line, in standard errors, from which on no value is identifiable."""
EXPONENT = Threshold(4.0, "decision 66: the true one at most 1.2 times the other on 14 drives")
"""Deviance of a Stribeck curve with one exponent, over that with the other, above which the
intervals of F_s and v_s leave it out."""
BENT = Threshold(
    3.0, "decision 66: a drive with 5 had F_s 8 % too low, 16 with at most 3.3 had not"
)
"""Deflection of the bristles over the travel for which a speed was held, above which the friction
curve does not give F_s and v_s."""
