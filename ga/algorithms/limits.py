"""When to stop: the limits that any optimiser can be given."""

from __future__ import annotations

from dataclasses import dataclass, fields

from stickslip.ga.errors import SettingsError

PROGRESS = 0.01
"""A best cost must fall by this fraction to count as progress."""


@dataclass(frozen=True)
class Limits:
    """What ends a run, whichever comes first; None never does.

    Parameters
    ----------
    generations : so many batches were evaluated
    evaluations : another batch would exceed this number of candidates
    seconds : so long since the optimiser was made or resumed, s
    target : the best cost is at most this, in the cost's unit
    patience : the best cost has not fallen by 1 % for so many evaluations

    Raises
    ------
    SettingsError : a limit that is not positive; a negative target
    """

    generations: int | None = None
    evaluations: int | None = None
    seconds: float | None = None
    target: float | None = None
    patience: int | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not (value >= 0 if field.name == "target" else value > 0):
                raise SettingsError(f"{field.name} must be above 0, or None, got {value!r}")

    def reached(
        self,
        *,
        generations: int,
        evaluations: int,
        batch: int,
        seconds: float,
        best: float,
        stagnant: int,
    ) -> str | None:
        """Return which limit ends the run, as a sentence, or None.

        Parameters
        ----------
        generations, evaluations, seconds : done so far
        batch : candidates of the next generation
        best : lowest cost
        stagnant : evaluations since the best cost last fell by `PROGRESS`
        """
        if self.target is not None and best <= self.target:
            return f"the best cost {best:.6g} reached the threshold {self.target:.6g}"
        if spent := self.spent(generations=generations, evaluations=evaluations, batch=batch):
            return spent
        if self.seconds is not None and seconds >= self.seconds:
            return f"{self.seconds:g} s have passed"
        if self.patience is not None and stagnant >= self.patience:
            return f"stagnation: the best cost has not fallen by 1 % in {stagnant} evaluations"
        return None

    def spent(self, *, generations: int, evaluations: int, batch: int) -> str | None:
        """Return which of the limits that are known beforehand ends the run, or None."""
        if self.generations is not None and generations >= self.generations:
            return f"all {self.generations} generations are done"
        if self.evaluations is not None and evaluations + batch > self.evaluations:
            return (
                f"the budget of {self.evaluations} evaluations is used "
                f"({evaluations} done, another generation takes {batch})"
            )
        return None
