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
RISE = Threshold(0.5)
"""Static friction beyond Coulomb friction, over that, for which the creep is said to suffice."""
STICKS = Threshold(0.2)
"""Stribeck velocity over F_c / K_p below which the loop is said to stick and slip instead."""
STEPS = Threshold(10.0)
"""Encoder steps of a bend or a creep below which it is said not to show."""
