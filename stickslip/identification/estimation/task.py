"""The settings of learning, the task of an estimation, and the choice of its criterion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from stickslip.catalog.parameters import check_learnable, friction_law
from stickslip.errors import UsageError, number
from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import OutputError, is_running
from stickslip.identification.fitting.search import Search
from stickslip.identification.selection.choice import Choice
from stickslip.logs import Finding, Recording
from stickslip.planning import LINEAR, Limits
from stickslip.thresholds import control_match, harm

CriterionName = Literal["auto", "loop", "inverse"]
CRITERIA = {"loop": OutputError.name, "inverse": InverseModel.name}


@dataclass(frozen=True)
class LearnSettings:
    """The settings of learning; each has a default.

    Attributes
    ----------
    law : of the catalogue, or ``auto`` for the one that predicts best where it is not fitted
    criterion : compares candidates with the recording: ``loop``, the output error of the simulated
        closed loop, ``inverse``, the force that the motion implies, or ``auto`` for what it allows
    seed : of the search
    search : which algorithm searches, and where it runs
    compensator : what is written: ``auto`` for the best on the drives that the log supports, or a
        name such as ``static+ekbf``
    friction_range : least and largest friction that the drive may come to have, over that in the
        log; a compensator must not be worse than none there
    absent : of ``encoder`` and ``motor_force``, what the controller cannot give a compensator
    limits : of the experiment on a rig, see ``plan``
    fixed_gains : whether those of the controller may not change, so that no others are tried
    """

    law: str = "auto"
    criterion: CriterionName = "auto"
    seed: int = 0
    search: Search = field(default_factory=Search)
    compensator: str = "auto"
    friction_range: tuple[float, float] = field(default_factory=harm.levels)
    absent: Sequence[str] = ()
    limits: Limits = LINEAR
    fixed_gains: bool = False

    def __post_init__(self) -> None:
        if self.law != "auto":
            check_learnable(self.law)
        if self.criterion not in ("auto", *CRITERIA):
            known = " or ".join(("auto", *CRITERIA))
            raise UsageError(f"criterion: expected {known}, got {self.criterion}")
        ends = [number("friction_range", one) for one in self.friction_range]
        if len(ends) != 2 or not 0.0 < ends[0] <= 1.0 <= ends[1] < np.inf:
            raise UsageError(
                "<friction_range>: expected the least and the largest friction over that in the "
                f"log, such as 0.7 1.3, with 1 between them; got {' '.join(map(str, ends))}"
            )

    @property
    def workers(self) -> int:
        """Number of parallel runs of an experiment."""
        return self.search.workers


@dataclass(frozen=True)
class Task:
    """The task of an estimation."""

    fmus: Path  # folder of the FMUs
    recording: Recording
    gains: Mapping[str, float] | None = None  # of the controller FMU by name; None if unknown
    # the law is that of the FMUs
    settings: LearnSettings = field(default_factory=partial(LearnSettings, law="lugre"))
    faults: tuple[Finding, ...] = ()  # findings of the checks that invalidate intervals or values
    choice: Choice | None = None  # of the law among all; None where the law is given

    @property
    def is_level(self) -> bool:
        """Whether friction does not rise towards rest, by the choice of the law."""
        return self.choice is not None and self.choice.chosen.candidate.is_level


def choose(task: Task, check: ControllerCheck | None) -> tuple[str, str]:
    """Return the criterion and why."""
    loop, inverse = OutputError.name, InverseModel.name
    if task.settings.criterion == "loop" and check is None:
        raise UsageError(
            "the output error needs the controller that made the log: give its gains, "
            "or use the inverse model as the criterion"
        )
    if task.settings.criterion != "auto":
        return CRITERIA[task.settings.criterion], "asked for"
    if task.recording.friction is not None and task.recording.force is None:
        return inverse, "friction itself was measured"
    law = friction_law(task.settings.law)
    if not law.is_smooth and task.recording.force is not None:
        return inverse, (
            f"the law {law.title} switches, so that a simulated loop does not follow small changes "
            "of its parameters smoothly"
        )
    if task.recording.friction_factor is not None:
        return (
            inverse,
            "friction grows with the weight of the arm, which the loop does not simulate",
        )
    if check is None:
        return inverse, "the controller is not known, so the loop cannot be run again"
    if np.isnan(check.error):
        return loop, "the controller is known and no force was logged"
    if check.error > control_match.EXACT:
        return inverse, (
            f"the controller given commands a force that differs by {check.difference} from "
            "the one logged, so the loop is not known well enough to run it again"
        )
    form = f", its {check.form}" if check.form else ""
    running = " and was running when the log began" if is_running(check.gains) else ""
    return loop, (
        f"the controller is known{form}{running}, and commands the logged force within "
        f"{check.difference}"
    )
