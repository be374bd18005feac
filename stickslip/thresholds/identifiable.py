"""How well a log identifies a parameter, and which value the compensator takes of it."""

from stickslip.thresholds import Threshold

WELL = Threshold(0.05)
"""Relative half-width of a 95 % interval up to which a parameter is identifiable."""
WEAKLY = Threshold(0.3)
"""The same up to which it is weakly identifiable; above it the compensator takes the end of the
interval at which the force is the weakest."""
PRIOR_DOMINATED = Threshold(0.5)
"""Standard error, as a share of the prior standard deviation, above which the prior decides, and
the parameter is not identifiable."""
SOFTEST = Threshold(0.5, "decision 62: 0.01 of the stiffness leaves 3.5 times the error")
"""Share of a fitted stiffness or damping that is not identifiable below which the compensator does
not go: a contact that is far too soft pushes after the motion."""
BEYOND = Threshold(1.25)
"""Static friction over the largest force in the log above which it is reduced to that force, unless
it is identifiable."""
