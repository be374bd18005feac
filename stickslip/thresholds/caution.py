"""Whether the user is warned of a compensator, by the loop around a drive with its own friction."""

from stickslip.thresholds import Threshold

GROWTH = Threshold(3.0, "docs/measurements/guards.md")
"""Logarithm of how much a deviation grows while friction falls, above which there is a warning."""
TOO_LARGE = Threshold(0.2, "decision 23")
"""Share by which the force must be too large to be as bad as none; below it there is a warning."""
PLATEAU = Threshold(0.3, unit="s")
"""Duration of a constant command from which on it is watched for stick-slip."""
STANDING = Threshold(0.01)
"""Swing of the velocity that is rest for a law without v_s, as a share of the fastest command."""
SWING = Threshold(2.0, "decision 79", unit="encoder steps")
"""Swing of a cascade at rest above which it hunts: the controller does not see one step less."""
REVERSALS = Threshold(2)
"""Reversals at rest from which on a swing is hunting; fewer are a slow return."""
