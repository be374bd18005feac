"""Whether the user is warned of a compensator, by the loop around a drive with its own friction."""

from stickslip.thresholds import Threshold

GROWTH = Threshold(3.0, "docs/measurements/guards.md")
"""Natural logarithm of how much a deviation grows while the command passes the speeds at which
friction falls; above it, 20-fold, there is a warning."""
TOO_LARGE = Threshold(0.2, "decision 23")
"""Share by which the force may be too large before the error is that of no compensator; below it
there is a warning."""
PLATEAU = Threshold(0.3, unit="s")
"""Duration of a constant command from which on it is watched for stick-slip."""
STANDING = Threshold(0.01)
"""Velocity of a swing that is rest, as a share of the fastest command, for a law without v_s; above
it, and above the speed of the plateau, there is a warning."""
SWING = Threshold(2.0, "decision 79")
"""Swing of a cascade at rest, in encoder steps, above which it hunts: the controller does not see
one less."""
REVERSALS = Threshold(2.0, "decision 79")
"""Reversals at rest from which on a swing is hunting; fewer are a slow return."""
