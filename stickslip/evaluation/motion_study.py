"""All motions for a page: the compensators compared, what each motion shows, and a weak loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from stickslip.evaluation.comparison import Entry, Evaluation, evaluate
from stickslip.evaluation.sensitivity import sensitivity
from stickslip.servo.rig import Rig
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop

UNCOMPENSATED, IDENTIFIED, LEARNED = "without", "identified", "learned"
"""Names of entries: no compensation, the identified parameters, the learned ones."""
WEAK = 0.1
"""Bandwidth of the weak loop, as a share of that of the loop."""
WEAK_ENTRIES = ("weak loop, without", "weak loop, exact")
"""The columns of the weak loop, without and with an exact compensator."""


@dataclass(frozen=True)
class MotionStudy:
    """What the motions gave.

    Attributes
    ----------
    loops : of the entries by name
    evaluation : of the entries, and after them of ``WEAK_ENTRIES``
    sensitivity : what ``stickslip.evaluation.sensitivity.sensitivity`` returns
    weak : the weak loop
    """

    loops: Mapping[str, VelocityLoop]
    evaluation: Evaluation
    sensitivity: pd.DataFrame
    weak: VelocityLoop

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the entries, those of the weak loop left out."""
        runs = next(iter(self.evaluation.runs.values()))
        return tuple(name for name in runs if name not in WEAK_ENTRIES)


def study_motions(
    rig: Rig,
    entries: Mapping[str, Entry],
    loop: VelocityLoop,
    exact: Mapping[str, float],
    feed: Feed = "nominal",
) -> MotionStudy:
    """Run all motions.

    It may use the true values, since it evaluates and does not learn.

    Parameters
    ----------
    entries : what is compared, ``UNCOMPENSATED`` and ``LEARNED`` among them
    loop : in which the sensitivity is found, and of which the weak one is made
    exact : the parameters of the exact compensator by name
    """
    weak = weakened(loop)
    weak_entries = dict(zip(WEAK_ENTRIES, (Entry(weak), Entry(weak, exact)), strict=True))
    evaluation = evaluate(rig, {**entries, **weak_entries}, feed)
    loops = {name: entry.loop for name, entry in entries.items()}
    return MotionStudy(loops, evaluation, sensitivity(rig, loop, exact, feed), weak)


def weakened(loop: VelocityLoop) -> VelocityLoop:
    """Return the loop with a tenth of the bandwidth: K_p in proportion to it, K_i to its square."""
    gains = WEAK * loop.K_p, WEAK**2 * loop.K_i
    return close_velocity_loop(loop.axis, loop.T_s, loop.tau_f, *gains)
