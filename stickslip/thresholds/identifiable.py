"""How well a log identifies a parameter, and which value the compensator takes of it."""

from stickslip.thresholds import Threshold

WELL = Threshold(0.05)
"""Relative half-width of a 95 % interval above which a parameter is only weakly identifiable."""
WEAKLY = Threshold(
    0.693, "decision 161: a factor of two; of 23 intervals between 0.3 and this 22 hold"
)
"""The same above which it is not identifiable."""
TAKEN = Threshold(0.3, "decision 161: with 0.69 a log that saturates is confident and wrong")
"""The same above which the compensator takes the value with the weakest force."""
PRIOR_DOMINATED = Threshold(0.5)
"""Standard error as a share of the prior's, above which a parameter is not identifiable."""
PRESLIDING = Threshold(
    0.04, "decision 173: GMS drives had -7, -6 and -5 %; decision 141: -4 to 4 % on sets"
)
"""Least relative standard error of stiffness and damping, where the force decides."""
QUANTISED = Threshold(
    0.35, "decision 169: contacts of 4.1 to 4.5 steps were fitted with 0.5 to 0.7 steps more"
)
"""The same in encoder steps of the presliding deflection F_c / sigma_0, where these are coarse."""
BESIDE_FORCE = Threshold(
    7e-3, "decision 182: of 40 vertical axes and arms F_c held on 33 without, on 37 with it"
)
"""The same of Coulomb friction beside a force of position, whatever decides."""
STATIC = Threshold(0.02, "decision 181: 78 of 89 intervals held without, 84 with it")
"""The same of static friction."""
STRIBECK = Threshold(0.08, "decision 181: 69 of 78 held without, 72 with it")
"""The same of the Stribeck velocity."""
RATIO = Threshold(
    0.03, "decision 187: with uneven friction z_ba was found as 0.66, 0.67 and 0.69 for 0.7"
)
"""Least standard error of a ratio that shapes the force."""
SOFTEST = Threshold(0.5, "decision 62: 0.01 of the stiffness leaves 3.5 times the error")
"""Share of a fitted stiffness or damping below which the compensator does not take it."""
BEYOND = Threshold(1.25)
"""Static friction over the largest force in the log above which it is reduced to that force."""
