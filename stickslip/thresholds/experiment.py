"""Whether an experiment can be planned within the limits that were given."""

from stickslip.thresholds import Threshold

DURATION = Threshold(2.0, unit="s")
"""Duration below which it is refused."""
SLOWEST = Threshold(100.0, unit="Hz")
"""Sample rate below which it is refused."""
FASTEST = Threshold(1e5, unit="Hz")
"""Sample rate above which it is refused."""
SAMPLES = Threshold(2e7)
"""Samples above which it is refused."""
