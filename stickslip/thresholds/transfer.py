"""Whether a learned drive holds for another log, and whether two logs can be compared."""

from stickslip.thresholds import Threshold

SMALL = Threshold(0.05)
"""Relative error of the force up to which the drive predicts the log, whatever explains it."""
MASS = Threshold(0.02)
"""Relative change of the mass above which the drive of the log is another one."""
VISCOUS = Threshold(0.05)
"""The same for viscous friction, at the top speed and as a share of F_c."""
FRICTION = Threshold(0.02)
"""The same for friction as a whole."""
OFFSET = Threshold(0.02)
"""The same for the constant force, as a share of F_c."""
INTERVAL = Threshold(0.15, "decision 67")
"""Relative standard error up to which an interval explains errors; a wider one explains any."""
IN_COMMON = Threshold(0.2)
"""Share of the shorter log's motion with the same command, below which logs are not compared."""
REPETITIONS = Threshold(3)
"""Repetitions of a command from which on they are the parts over which an interval is computed."""
SAME = Threshold(0.01)
"""Difference of two commands up to which they are the same, as a share of the speed near by."""
STRETCH = Threshold(0.3, unit="s")
"""Duration below which the same command in both logs is by chance."""
MOVING = Threshold(0.01)
"""Share of the largest speed above which a command moves the drive, so that its time counts."""
