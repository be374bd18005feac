"""Checks before export: where feedforward of friction would increase the tracking error.

Each guard returns findings, one line each: what, figure, limit, what to do. All evaluate a loop
whose axis has exactly the friction that the compensator assumes.

    stribeck      friction that falls with speed, against the damping of the loop
    tolerance     how much too large a force may be, compared with its confidence interval
    hunting       stick-slip at a constant command
    benefit       tracking errors without and with the compensator, and the largest share of its
                  force that never increases them
"""

from stickslip.evaluation.guards.benefit import Benefit, Tried, benefit_of
from stickslip.evaluation.guards.hunting import hunting
from stickslip.evaluation.guards.stribeck import stribeck
from stickslip.evaluation.guards.tolerance import tolerance
from stickslip.evaluation.guards.trial import Finding, Trial

__all__ = [
    "Benefit",
    "Finding",
    "Trial",
    "Tried",
    "benefit_of",
    "hunting",
    "inspect",
    "stribeck",
    "tolerance",
]


def inspect(trial: Trial, standard_errors: dict[str, float]) -> list[Finding]:
    """Return what all guards find; standard errors in the units of the parameters, some or none."""
    return [*stribeck(trial), *tolerance(trial, standard_errors), *hunting(trial)]
