"""Whether a simulated drive explains a log, so that its values and intervals hold."""

from stickslip.thresholds import Threshold

MODEL_ERROR = Threshold(2.0, "decision 25")
"""Error of a simulated loop, over that of encoder and noise, above which the drive is another one:
the force decides instead, or there is a warning; ``validate`` calls an error up to it explained."""
RUNS_AWAY = Threshold(10.0, "below 4 where a loop follows its command, or sticks and slips on it")
"""Peak of a simulated velocity over the largest commanded one above which a run has failed, and
gives no figures: a loop that does not follow passes it within some tens of samples."""
DELAY_AT_BOUND = Threshold(0.01, unit="samples")
"""Distance of the delay from a bound of the fit below which the delay is taken to be outside."""
CHANGE = Threshold(0.03)
"""Relative change of friction from begin to end of a log above which there is a warning."""
CHANGE_CERTAIN = Threshold(5.0)
"""The same change in its standard errors: one with less is by chance."""
COARSE = Threshold(0.005, "decision 25")
"""Speed of one encoder step per sample, as a share of the top speed, above which the fit by the
force is corrected for the encoder; below it the surrogate controller would bias it more."""
ALIKE = Threshold(2.0, "decision 32")
"""Ratio of the mean squares of resimulated and recorded residuals, or its inverse, above which the
surrogate controller is unlike the drive's, and the correction only widens the intervals."""
