"""The settings of learning, and the task of an estimation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from stickslip.identification.fitting.search import Search
from stickslip.identification.selection import Choice
from stickslip.logs import Finding, Recording
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


@dataclass(frozen=True)
class Task:
    """The task of an estimation."""

    fmus: Path  # folder of the FMUs
    recording: Recording
    # of the controller FMU by name; None when the controller is not known
    gains: Mapping[str, float] | None = None
    settings: LearnSettings = field(default_factory=LearnSettings)  # the law is that of the FMUs
    faults: tuple[Finding, ...] = ()  # findings of the checks that invalidate intervals or values
    choice: Choice | None = None  # of the law among all; None where the law is given

    @property
    def is_level(self) -> bool:
        """Whether friction does not rise towards rest, by the choice of the law."""
        return self.choice is not None and self.choice.chosen.candidate.is_level
