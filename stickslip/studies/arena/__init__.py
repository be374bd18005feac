"""All compensators on all drives under the same conditions: ``stickslip arena``.

    drives, entrants -> tuned from measured signals (``tuning.py``)
    -> validated on other commands (``validation.py``) -> cells, kept one by one (``protocol.py``)
    -> arena.csv.gz (``table.py``), arena.html (``page.py``)

Drives and entrants are data: ``drives.toml``, ``entrants.toml``, and every law and compensator of
``models`` that these do not name. What tunes sees the encoder and the motor force of a drive only;
the truth of a drive is in the start values of its FMU.
"""

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
