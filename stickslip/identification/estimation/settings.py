"""What can be chosen when a drive is learned from a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from stickslip.identification.fitting.search import Search
from stickslip.planning import LINEAR, Limits

CriterionName = Literal["auto", "output error", "inverse model"]


@dataclass(frozen=True)
class LearnSettings:
    """The settings of learning; each has a default.

    Attributes
    ----------
    law : of the catalogue, or ``auto`` for the one that predicts best where it is not fitted
    criterion : compares candidates with the recording; ``auto`` takes the one that it allows
    seed : of the search
    seeds : number of searches, each with a seed of its own
    search : which algorithm searches, and where it runs
    compensator : what is written: ``auto`` for the best on the drives that the log supports, or a
        name such as ``static+ekbf``; by default feedforward of the law, and a disturbance observer
        if it helps
    absent : of ``encoder`` and ``motor_force``, what the controller cannot give a compensator
    limits : of the experiment on a rig, see ``plan``
    """

    law: str = "lugre"
    criterion: CriterionName = "auto"
    seed: int = 0
    seeds: int = 1
    search: Search = field(default_factory=Search)
    compensator: str = ""
    absent: Sequence[str] = ()
    limits: Limits = LINEAR

    @property
    def workers(self) -> int:
        """Number of parallel runs of an experiment."""
        return self.search.execution.workers
