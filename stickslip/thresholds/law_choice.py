"""Which friction law explains a log, and which of its parts the log shows."""

from stickslip.thresholds import Threshold

TIE = Threshold(2.0, "decision 60")
"""Standard errors over blocks of the difference of two squared errors up to which laws are tied."""
MARGIN = Threshold(0.98, "decision 60")
"""Ratio of two errors above which they are tied in any case."""
STATIC = Threshold(1.02)
"""Held-out error over that of Coulomb-Stribeck friction, with F_s = F_c where that is better, above
which a law is not chosen, whatever the standard error."""
UNIDENTIFIED = Threshold(0.7, "decision 60: 0.87 to 0.92 on EMPS, where no parameter is identified")
"""Error over Coulomb's below which a law takes part though none of its parameters is identified;
over that of another law, below which the two are not tied."""
RISES = Threshold(2.0)
"""Standard errors by which friction must rise towards rest to be seen to do so."""
RISE_WORTH = Threshold(1.1)
"""Growth of the mean square without a rise towards rest, up to which the rise is left out."""
EXPONENT = Threshold(0.99, "decision 32: 100 logs of exponent 1 differed by up to 0.7 %")
"""Ratio of mean squares below which another exponent is taken; above it the intervals hold both."""
EXPONENT_BIASED = Threshold(
    0.85, "docs/measurements/sound-drives.md: 5 of 38 such logs are beyond it, all right"
)
"""The same where coarse encoder steps, or slips shorter than the low-pass, bias the curve."""
ALIKE = Threshold(1.1)
"""Held-out error over that of the chosen law up to which the interval of the stiffness holds that
of another law."""
