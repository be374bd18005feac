"""Whether what was tuned on a drive or its models is taken, and which models are."""

from stickslip.thresholds import Threshold

FIT_WORSE = Threshold(1.1, "decision 124: means of five runs scatter by 1 to 6 %")
"""Cost of a fit of the friction, and its error in slow motions, over the start's, above which the
start is kept; what only fits the training command leaves 1.2 to 16 times its error."""
LOOP_WORSE = Threshold(1.02, "runs within an encoder step scatter by 1 to 5 %, medians by 1.6 %")
"""Error or force of a learned loop over that of the reference above which it is not taken."""
LOOP_BETTER = Threshold(
    0.98, "runs scatter as above; one at a hundredth of its force, that could not move, had 0.997"
)
"""Mean of the same ratios above which the reference stays: what is not better is not changed."""
ENDED = Threshold(
    0.95, "two drives, two seeds: 150 candidates ended 4 to 25 % above 400 of them, 300 at most 2 %"
)
"""Least cost of a search over that after two thirds of it, below which it had not ended."""
SENSITIVITY = Threshold(1.98, "2.0 of textbooks, less 1 % for the error of the identified mass")
"""Peak sensitivity above which a candidate of the loop is not run."""
CHATTER = Threshold(
    0.3, "decision 140: the loops of ten sound drives have 0.10 to 0.61, 0.26 in the median"
)
"""Largest RMS change of the motor force from sample to sample, over the Coulomb friction, of a loop
that is tuned on simulated drives, unless the present loop comes near it."""
FORCE = Threshold(0.98)
"""Largest motor force of such a loop over the force limit, unless the present loop has more."""
ERRS_ALIKE = Threshold(
    0.12, "decision 131: 0.1 with ripple and asymmetry, 0.3 to 0.9 of another law"
)
"""RMS of logarithms of a model's errors over the drive's above which other laws are searched."""
ERRS_WELL = Threshold(0.05)
"""The same, up to which a search ends."""
HOPELESS = Threshold(2.0, "the drive's own law had up to 1.7 times the least")
"""The same over the least among the laws at their start, above which a law is not searched."""
FURTHER = Threshold(1.3, "searches of one law from two seeds differ by as much")
"""The same over that of the best model, up to which a further model is used beside it."""
