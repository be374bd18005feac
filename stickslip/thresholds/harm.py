"""Whether a compensator is withheld, or written with a share of its force."""

from stickslip.thresholds import Threshold

WORSE = Threshold(1.02, "decision 134")
"""Largest ratio of the error with a compensator to that without it, on the median of the drives
with the same level of friction on the same motion; above it a smaller share of the force is tried,
and at last none is written."""
DRIVES = Threshold(0.75, "decision 135: with 0.5, three of four drives were up to 2.6 times worse")
"""Share of the drives with the same level of friction whose ratio is at most ``MORE``."""
MORE = Threshold(1.05, "decision 140: at 1.02 a compensator that leaves 0.54 was refused for 1.04")
"""Largest ratio on that share of the drives."""
SCATTER = Threshold(
    1.4, "decision 166: at 1.3 a force that does no harm was reduced for 1.31, once 1.294"
)
"""The largest ratio on any drive; single runs stick and slip by chance."""
SLOWLY = Threshold(
    1.3, "decision 157: 1.76 and 2.16 on two drives that were worse, 1.40 at most on sound ones"
)
"""Largest ratio on the median of the drives in a small move as slow as the loop."""
PERSISTS = Threshold(
    1.2, "decision 174: 1.25 to 2.4 on four drives that were worse, 1.22 at most on sound ones"
)
"""Largest ratio on one drive in most of three small moves, or creeps, beside each other."""
FALLS = Threshold(0.7, "docs/adaptation.md: friction drifts by up to 30 % with temperature")
"""Least friction that the drive may come to have, over that in the log, unless a range is given."""
GROWS = Threshold(1.3, "docs/adaptation.md: friction drifts by up to 30 % with temperature")
"""The same for the largest friction."""
EXPLAINS = Threshold(
    1.3, "decision 140: the true law had at most 1.03; elasto-plastic drives have others"
)
"""Held-out error of another law, over the one that noise and steps explain or over the least among
the laws, up to which the drive may be one of that law."""
RESOLVED = Threshold(
    15.0, "decision 135: at 5 to 14, the sigma_0 taken was 0.4 to 0.7 times the true"
)
"""Encoder steps of the least presliding deflection that a log supports, below which the log does
not show presliding, so that observers have an onset; the longest that is tried where the law has no
presliding (decision 185)."""
HIDDEN = Threshold(
    5.0, "docs/measurements/sound-drives.md: least of the drives with a ratio above 1"
)
"""Encoder steps of the shortest presliding deflection for which a drive of a law without one is
tried, and an onset is made."""
COARSE = Threshold(30.0, "decision 137: of 7 true steps 10 to 21 were fitted")
"""Encoder steps of a fitted presliding deflection below which the true one may be shorter."""
UNSURE = Threshold(1.4, "decision 137: 0.66 in moves of 4 deflections, 3.7 in moves of 5")
"""Factor by which the deflection of a drive may be longer or shorter there."""
STIFFER = Threshold(3.0, "decision 137: true values were up to 2.9 times the fit")
"""Largest stiffness of a drive on which a compensator is tried, over that fitted, there."""
ONSET = Threshold(1.25, "the reference of 40 sound drives goes up to 1.23 times a small move")
"""Displacement from which an observer acts, over the longest of the moves in which the drive may
stick."""
RESERVE = Threshold(1.3, "decision 62")
"""Largest static friction of a drive on which a compensator is tried, over that in the log."""
WIDE = Threshold(3.0, "decision 140: 28 values of sigma_0 that logs do not show were 2.5 at most")
"""Value of one that is poorly identified on which a compensator is tried, over that fitted."""
LIMIT = Threshold(10.0, "decision 163: runs of a loop that ran away: over 34 min with 1000, 43 s")
"""Largest force of a motor whose limit is not known, over the strongest in the log."""
PROMISED = Threshold(2.0, "docs/measurements/sound-drives.md: 168 of 190 true ratios lie there")
"""Factor by which the ratio of errors of the true drive may lie beyond the range over the simulated
drives: they have the laws that explain the log, not its own."""


def rule() -> str:
    """Return when a compensator is acceptable: in each motion and at each level of friction."""
    return (
        f"its error is at most {WORSE:g} times that without it on half of the drives, {MORE:g} "
        f"times on {100.0 * DRIVES:g} % of them, and {SCATTER:g} times on all; and on no drive "
        "does the error grow by more than it falls in the mean"
    )


def levels() -> tuple[float, float]:
    """Return the least and the largest friction that a drive may come to have."""
    return FALLS, GROWS
