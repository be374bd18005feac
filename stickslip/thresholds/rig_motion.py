"""Whether a motion on a rig is accepted, ended or refused, and when a drive is at rest."""

from stickslip.thresholds import Threshold

SPACING = Threshold(0.01)
"""Relative error of the mean spacing of a log's times above which the log is refused."""
RETURNED = Threshold(2e-5, unit="m")
"""Distance from where motions begin up to which a drive has returned."""
STALL = Threshold(10.0, unit="s")
"""Time without a new sample after which a motion is stopped."""
AT_REST = Threshold(1e-3, unit="m/s")
"""Speed below which a drive that is stopped is at rest."""
SETTLED = Threshold(0.1, unit="s")
"""Time at rest after which the brake holds."""
LONGEST_STOP = Threshold(3.0, unit="s")
"""Time of a stop after which the brake holds in any case."""
