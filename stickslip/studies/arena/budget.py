"""What an entrant may use while it is tuned."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """What each entrant may use on each drive."""

    evaluations: int = 180  # candidates
    seconds: float = 2000.0  # of motion of the drive [s]

    def runs(self, duration: float) -> int:
        """Return how many candidates can be evaluated, each with a run of a duration [s]."""
        return max(1, min(self.evaluations, int(self.seconds / duration)))
