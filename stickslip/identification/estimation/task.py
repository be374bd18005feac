"""The task of an estimation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from stickslip.identification.estimation.settings import LearnSettings
from stickslip.identification.selection import Choice
from stickslip.logs import Finding, Recording


@dataclass(frozen=True)
class Task:
    """The task of an estimation.

    Attributes
    ----------
    fmus : folder of the FMUs
    gains : of the controller FMU by name; None when the controller is not known
    settings : the law is that of the FMUs
    faults : findings of the checks that invalidate intervals or values
    choice : of the law among all; None where the law is given
    """

    fmus: Path
    recording: Recording
    gains: Mapping[str, float] | None = None
    settings: LearnSettings = field(default_factory=LearnSettings)
    faults: tuple[Finding, ...] = ()
    choice: Choice | None = None

    @property
    def is_level(self) -> bool:
        """Whether friction does not rise towards rest, by the choice of the law."""
        return self.choice is not None and self.choice.chosen.candidate.is_level
