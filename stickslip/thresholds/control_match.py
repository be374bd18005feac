"""Whether the controller that is known is that of the log."""

from stickslip.thresholds import Threshold

EXACT = Threshold(0.01, "decision 25")
"""Relative error of the commanded force above which the loop is not simulated with the controller,
and the compensator is tried in another one."""
NEAR = Threshold(0.05)
"""The same error above which the result says that the controller differs."""
FOREIGN = Threshold(
    0.3, "noise of 3 N beside friction of 6 N makes 0.1, a position 10 % too large 10"
)
"""The same error above which a rig did not run the loop that it was sent."""
OUT_OF_SCALE = Threshold(0.1, "decision 39")
"""Share of the force, and of the error, that one factor may leave to be the cause of the error."""
OTHER_FORM = Threshold(0.5, "decision 32")
"""Share of the error below which another form, or one that was running, is the true one."""
GAINS_SHOWN = Threshold(0.9)
"""Share of the force's variance that a PI controller must explain to be that of the log."""
ERRS_ALIKE = Threshold(
    1.25, "docs/measurements/sound-drives.md: 0.96 to 1.08 on 40 drives; 0.69 and less with a fault"
)
"""Factor, up or down, between the simulated and the measured tracking error of the log beyond which
gains, units or limits of the loop cannot be those of the log."""
