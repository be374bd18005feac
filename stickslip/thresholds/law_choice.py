"""Which friction law explains a log, and which of its parts the log shows."""

from stickslip.thresholds import Threshold

TIE = Threshold(2.0, "decision 60")
"""Standard errors over blocks of the difference of two squared errors up to which laws are tied."""
MARGIN = Threshold(0.98, "decision 60")
"""Ratio of two errors above which they are tied in any case."""
UNIDENTIFIED = Threshold(0.7, "decision 60: 0.87 to 0.92 on EMPS, where no parameter is identified")
"""Error over that of Coulomb and viscous friction below which a law takes part though the log
identifies none of its parameters."""
RISES = Threshold(2.0)
"""Standard errors by which friction must rise towards rest to be seen to do so."""
RISE_WORTH = Threshold(1.1)
"""Factor by which the mean square must grow without a rise of friction towards rest, where the rise
is hardly identified, for the rise to be kept."""
EXPONENT = Threshold(0.99, "decision 32: 100 logs of exponent 1 differed by up to 0.7 %")
"""Ratio of mean squares below which another exponent of the Stribeck curve is taken; above it both
are within the intervals."""
