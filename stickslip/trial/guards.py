"""Checks before export: where feedforward of friction would increase the tracking error.

``benefit`` tries compensators on a ``family`` of drives that the log supports, and finds the
largest share of the force that never increases the error. The guards return findings, one line
each: what, figure, limit, what to do. They evaluate a loop whose axis has exactly the friction that
the compensator assumes.

    stribeck      friction that falls with speed, against the damping of the loop
    tolerance     how much too large a force may be, compared with its confidence interval
    hunting       stick-slip at a constant command
    hold          the same at rest in a cascade, after motions of several sizes
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager

from stickslip.cosim import Trapezoid
from stickslip.fmi.process import temporary_folder
from stickslip.models import Law
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.trial.benefit import (
    FEEDFORWARD,
    NONE,
    Bench,
    Benefit,
    TrialError,
    Variant,
    best_of,
    feedforward,
)
from stickslip.trial.family import Drive, Evidence, commands, family
from stickslip.trial.hold import Hold, holds, hunting_at_rest
from stickslip.trial.hunting import hunting
from stickslip.trial.single_run import Finding, Trial
from stickslip.trial.stribeck import stribeck
from stickslip.trial.tolerance import tolerance

__all__ = [
    "NONE",
    "Bench",
    "Benefit",
    "Drive",
    "Evidence",
    "Finding",
    "Hold",
    "Trial",
    "TrialError",
    "Variant",
    "bench_of",
    "benefits_on_drives",
    "best_of",
    "commands",
    "family",
    "feedforward",
    "findings_of",
    "holds",
    "hunting",
    "hunting_at_rest",
    "inspect",
    "stribeck",
    "tolerance",
]


def inspect(trial: Trial, standard_errors: dict[str, float]) -> list[Finding]:
    """Return what all guards find; standard errors in the units of the parameters, some or none."""
    return [*stribeck(trial), *tolerance(trial, standard_errors), *hunting(trial)]


def benefits_on_drives(
    bench: Bench,
    friction: Mapping[str, float],  # as fitted, parameters of the law by name
    variants: Sequence[Variant],  # each is tried, in this order
    standard_errors: Mapping[str, float],  # of the friction, by name
    *,
    # whether the guards take the whole force instead of the share that is acceptable
    force: bool = False,
) -> tuple[tuple[Benefit, ...], list[Finding]]:
    """Try ways to compensate on the family of drives of a bench.

    Returns
    -------
    benefits : of each variant
    findings : of all guards on the best feedforward among the variants
    """
    benefits = bench.benefits(variants)
    best = best_of(benefits)
    share = 1.0 if force else best.share
    found = findings_of(bench, friction, best, share, standard_errors=standard_errors)
    if bench.loop.K_x:
        shared, step = best.variant.share(bench.law, share), bench.datasheet.encoder_step
        found += hunting_at_rest(holds(bench, [NONE, shared]), shared, step)
    return benefits, found


@contextmanager
def bench_of(
    law: Law,  # of the feedforward
    loop: VelocityLoop,
    friction: Mapping[str, float],  # as fitted, parameters of the law by name
    drives: Sequence[Drive],  # see ``family``
    command: Trapezoid,  # at the highest speed; see ``commands``
    datasheet: Datasheet,
    *,
    feed: Feed = "nominal",
    workers: int = 1,
) -> Iterator[Bench]:
    """Build the loop in which variants are tried."""
    with temporary_folder() as folder:
        step, rotary = datasheet.encoder_step, loop.axis.rotary
        tried = commands(command, loop.T_s, friction, step, rotary=rotary)
        bench = Bench(
            folder,
            law,
            loop,
            drives,
            commands=tried,
            feed=feed,
            datasheet=datasheet,
            workers=workers,
        )
        with closing(bench):
            yield bench


def findings_of(
    bench: Bench,
    friction: Mapping[str, float],
    benefit: Benefit,
    share: float,
    standard_errors: Mapping[str, float],
) -> list[Finding]:
    """Return what all guards find on a share of the feedforward of a variant.

    They evaluate a law, in a loop that does not run away on the drive as fitted.
    """
    if benefit.variant.feedforward_model != FEEDFORWARD or benefit.fitted_ratio == math.inf:
        return []
    trial = Trial(
        bench.folder_of(bench.law.name),
        bench.loop,
        friction,
        benefit.variant.share(bench.law, share).feedforward,
        v_cmd=bench.commands[0].v_cmd,
        feed=bench.feed,
        datasheet=bench.datasheet,
        law=bench.law,
    )
    return inspect(trial, dict(standard_errors))
