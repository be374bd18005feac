"""Whether the user is warned that a friction law does not explain a log, and of which cause."""

from stickslip.thresholds import Threshold

NOTED = Threshold(1.5, "decision 60")
"""Error where a law was not fitted, over that of noise, above which there is a warning."""
EXPLAINED = Threshold(2.0, "decisions 25, 60 and 156")
"""The same ratio, of a force, a simulated loop or another log, above which the drive is not
explained: no interval holds, values are coarse, and the ratio is told wherever they are used."""
SMALLEST = Threshold(0.02, "decision 60")
"""Unexplained force, as a share of the measured one, up to which there is no warning."""
BEATEN = Threshold(0.7)
"""Error of another law over that of the law, below which there is a warning whatever noise
explains: a wrong drive may oscillate when it is simulated, which looks like noise."""
LARGE = Threshold(0.1, "decision 60")
"""Error as a share of the force above which the other laws are tried in any case."""
LIKELY = Threshold(0.5)
"""Share of the unexplained mean square that a cause removes above which it is the likely one."""


def excess(ratio: float, by: str = "noise and encoder steps") -> str:
    """Return an error in words, over the one that is explained ``by`` something."""
    limits = f"at most {NOTED:g} is good, above {EXPLAINED:g} too much"
    times = f"{ratio:.2g}" if ratio < 100.0 else "more than 100"
    return f"{times} times what {by} explain ({limits})"
