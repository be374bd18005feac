"""Whether the user is warned of a compensator, by how a cascade rests."""

from stickslip.thresholds import Threshold

SWING = Threshold(2.0, "decision 79", unit="encoder steps")
"""Swing of a cascade at rest above which it hunts: the controller does not see one step less."""
REVERSALS = Threshold(2)
"""Reversals at rest from which on a swing is hunting; fewer are a slow return."""
