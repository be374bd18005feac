"""Whether a log is long enough, and which parameters its motion may show, before it is learned."""

from stickslip.thresholds import Threshold

FEWEST = Threshold(20, unit="samples")
"""Length of the longest stretch without gaps below which a log is refused."""
DURATION = Threshold(1.0, unit="s")
"""Duration below which there is a warning that the log is short."""
SAMPLES = Threshold(500)
"""The same in samples."""
LONGEST = Threshold(30, "plans last 20 s", unit="s")
"""Duration above which only the stretches that show most of the drive are learned from."""
MOST = Threshold(100_000, unit="samples")
"""The same in samples; the stretches together have the larger of both."""
TOGETHER = Threshold(2, "decision 141: three logs of 10 s take 56 s of CPU, one of 20 s 43 s")
"""The same for several logs together, over that for one."""
TRAVEL = Threshold(100, unit="encoder steps")
"""Travel below which there is a warning that the encoder is coarse."""
MOVING = Threshold(0.1)
"""Share of the time in motion below which the drive hardly moves."""
SLIDING = Threshold(50, unit="samples")
"""Sliding below which neither the mass nor faults of the force show."""
INERTIAL = Threshold(0.05, "decision 38")
"""Share of the force by acceleration below which m is poorly identifiable, and not questioned."""
SLOW = Threshold(0.05)
"""Share of the motion that is slow below which F_s and v_s are poorly identifiable."""
SPEEDS = Threshold(3)
"""Ratio of the largest to the smallest usual speed below which b and F_c are hard to separate."""
ONE_WAY = Threshold(0.01, "decision 180: 0.002 and less in seven logs, 0.44 and more in eight")
"""Share of the way in the other direction below which F_c and the offset cannot be told apart."""
REVERSALS = Threshold(2)
"""Reversals below which F_c and the offset are hard to separate."""
SPACING = Threshold(20, "test_faulty_logs.py: at 13, b is 33 N s/m for 0", unit="samples")
"""Distance of two reversals below which they are too fast for the sample rate."""
TURN = Threshold(3)
"""Samples, and encoder steps, in which friction reverses, below which sigma_0 hardly shows."""
TURNS = Threshold(100)
"""Samples in all such reversals together, the same."""
