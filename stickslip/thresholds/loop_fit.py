"""Whether a simulated drive explains a log, so that its values and intervals hold."""

from stickslip.thresholds import Threshold

RUNS_AWAY = Threshold(10.0, "below 4 where a loop follows its command, or sticks and slips on it")
"""Peak of a simulated velocity over the largest commanded one, above which the run has failed."""
DELAY_AT_BOUND = Threshold(0.01, unit="samples")
"""Distance of the delay from a bound of the fit below which the delay is taken to be outside."""
DELAY_KNOWN = Threshold(
    2.0,
    "decision 178: a friction that misses by 30 % had 2.5; 10 of 127 sound logs",
    unit="samples",
)
"""Standard error of the delay above which intervals are not believed, where the force decides."""
SPRING = Threshold(
    0.2, "docs/measurements/real-logs.md: 0.36 with a cable; of 61 sound logs at most 0.02"
)
"""Presliding deflection F_c / sigma_0 over the travel above which a spring passes for friction."""
CHANGE = Threshold(0.03)
"""Relative change of friction from begin to end of a log above which there is a warning."""
CHANGE_CERTAIN = Threshold(5.0)
"""The same change in its standard errors: one with less is by chance."""
COARSE = Threshold(0.005, "decision 25")
"""Speed of one encoder step per sample, as a share of the top speed, above which a surrogate
controller corrects the fit by the force; with finer steps it would bias the fit."""
ALIKE = Threshold(2.0, "decision 32")
"""Ratio of resimulated to recorded mean squares, or its inverse, above which that is not valid."""
