"""Where feedforward of friction would hurt, told before a compensator leaves the house.

Each guard returns findings, one line each: what, figure, limit, what to do. All judge a loop whose
axis has the friction that the compensator believes in, so they find what is wrong even then.

    stribeck      friction that falls with speed, against the damping of the loop
    tolerance     how much too large a force may be, against how well it is known
    hunting       stick and slip while the command stands
    worth         tracking errors without and with it, and at which share of its force it never
                  makes them worse
"""

from stickslip.evaluation.guards.finding import Finding
from stickslip.evaluation.guards.hunting import hunting
from stickslip.evaluation.guards.stribeck import stribeck
from stickslip.evaluation.guards.tolerance import tolerance
from stickslip.evaluation.guards.trial import Trial
from stickslip.evaluation.guards.worth import (
    Tried,
    Worth,
    try_out,
)

__all__ = [
    "Finding",
    "Trial",
    "Tried",
    "Worth",
    "hunting",
    "inspect",
    "stribeck",
    "tolerance",
    "try_out",
]


def inspect(trial: Trial, standard_errors: dict[str, float]) -> list[Finding]:
    """Return what all guards find; standard errors in the units of the parameters, some or none."""
    return [*stribeck(trial), *tolerance(trial, standard_errors), *hunting(trial)]
