"""Checks before export: where feedforward of friction would increase the tracking error.

Each guard returns findings, one line each: what, figure, limit, what to do. All evaluate a loop
whose axis has exactly the friction that the compensator assumes.

    stribeck      friction that falls with speed, against the damping of the loop
    tolerance     how much too large a force may be, compared with its confidence interval
    hunting       stick-slip at a constant command
    benefit       tracking errors without and with the compensator, and the largest share of its
                  force that never increases them
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stickslip.cosim import Trapezoid
from stickslip.evaluation.guards.benefit import Benefit, Tried, benefit_of
from stickslip.evaluation.guards.hunting import hunting
from stickslip.evaluation.guards.stribeck import stribeck
from stickslip.evaluation.guards.tolerance import tolerance
from stickslip.evaluation.guards.trial import Finding, Trial
from stickslip.fmi.process import temporary_folder
from stickslip.models import Law
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.systems import Feed, build_fmus
from stickslip.servo.velocity_loop import VelocityLoop

__all__ = [
    "Benefit",
    "Finding",
    "Trial",
    "Tried",
    "benefit_of",
    "benefit_on_drives",
    "hunting",
    "inspect",
    "stribeck",
    "tolerance",
]


def inspect(trial: Trial, standard_errors: dict[str, float]) -> list[Finding]:
    """Return what all guards find; standard errors in the units of the parameters, some or none."""
    return [*stribeck(trial), *tolerance(trial, standard_errors), *hunting(trial)]


def benefit_on_drives(
    law: Law,
    loop: VelocityLoop,
    friction: Mapping[str, float],
    compensator: Mapping[str, float],
    command: Trapezoid,
    datasheet: Datasheet,
    standard_errors: dict[str, float],
    *,
    feed: Feed = "nominal",
    rotary: bool = False,
    force: bool = False,
) -> tuple[Benefit, list[Finding]]:
    """Try a compensator on simulated drives; return its benefit and what all guards find.

    Parameters
    ----------
    friction : of the drive, parameters of the law by name
    force : whether the guards take its whole force instead of the share that is acceptable
    """
    duration = command.corners()[-1] + command.begin
    v_cmd = command.sample(np.arange(round(duration / loop.T_s) + 1) * loop.T_s)
    with temporary_folder() as folder:
        build_fmus(folder, {"law": law.name}, law.name)
        trial = Trial(folder, loop, friction, compensator, v_cmd, feed, datasheet, law)
        benefit = benefit_of(trial, rotary=rotary)
        share = 1.0 if force else benefit.share
        written = replace(trial, compensator=law.share(compensator, share))
        return benefit, inspect(written, standard_errors)
