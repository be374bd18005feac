"""What an entrant may use while it is tuned."""

from __future__ import annotations

from dataclasses import dataclass

STARTS = 6  # runs of each command
TUNINGS = 5  # random seeds with which an entrant is tuned whose rank moves with the seed


@dataclass(frozen=True)
class Budget:
    """What each entrant may use on each drive."""

    evaluations: int = 90  # candidates
    seconds: float = 2000.0  # of motion of the drive [s]

    def runs(self, duration: float) -> int:
        """Return how many candidates can be evaluated, each with a run of a duration [s]."""
        return max(1, min(self.evaluations, int(self.seconds / duration)))
