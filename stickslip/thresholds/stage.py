"""Whether an experiment of the identification on a rig shows what it is for."""

from stickslip.thresholds import Threshold

TRAVEL = Threshold(100, unit="encoder steps")
"""Motion by the strong sine below which the identification ends: the stage does not slide."""
ENCODER_STEP = Threshold(4.0)
"""Smallest change of position, over the data sheet's encoder step, above which it ends."""
HELD = Threshold(0.2, "0.05 on sound drives, 0.4 and more on a light one that sticks and slips")
"""Fluctuation of the velocity below 20 Hz, as a share of its mean, above which a speed is left out:
0.2 to 0.3 are usual at the lowest speeds with a coarse encoder or a slow amplifier."""
SPEEDS_HELD = Threshold(4)
"""Speeds below which it ends: with the break-away the fit has as many unknowns."""
RISE = Threshold(0.02)
"""(F_s - F_c) / F_c below which v_s is a start value."""
POOR = Threshold(0.2)
"""Share of the deflection that the fit of presliding leaves above which there is a warning."""
BREAKAWAY = Threshold(2e-3, unit="m/s")
"""Velocity above which a stage has broken away: no bristle creeps as fast."""
BREAKAWAY_SAMPLES = Threshold(20)
"""Samples to the end of a ramp that must be faster; with fewer a higher ramp follows."""
