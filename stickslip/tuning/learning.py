"""What learning the friction on a drive needs: the study, the cost (6), and the genes of Fig. 3.

Cost is the sum in (6), of v - v_r over the training run: v as the encoder shows it, v_r from the
nominal loop, both through the same low-pass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stickslip import ga
from stickslip.catalog.parameters import unit_of
from stickslip.catalog.space import ParameterSpace
from stickslip.identification.stages import Estimate
from stickslip.rigs.contract import Recorded, Rig
from stickslip.servo.measurement import CUTOFF, Array, smoothed
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop

BOUNDS = (0.1, 100.0)  # times the identified value, as in the paper


@dataclass(frozen=True)
class VelocityCost:
    """Sum of (v - v_r)^2 [m^2/s^2] over the samples of a run on the drive."""

    T_s: float  # sample period [s]
    cutoff: float | None = CUTOFF  # of the low-pass of v - v_r [Hz], None for none

    def __call__(self, result: Recorded) -> float:
        """Return the cost of the recorded ``drive.x_enc`` [m] and ``nominal.v_r`` [m/s]."""
        gap = self.gap(result)
        return float(np.sum(gap * gap))  # the same bits whatever the threads of the linear algebra

    def gap(self, result: Recorded) -> Array:
        """Return v - v_r (n,) [m/s]."""
        v = np.gradient(result["drive.x_enc"], self.T_s)
        gap = v - result["nominal.v_r"]
        return gap if self.cutoff is None else smoothed(gap, self.T_s, self.cutoff)


@dataclass(frozen=True)
class Study:
    """What a learning run needs, and nothing of the drive but its rig."""

    rig: Rig
    loop: VelocityLoop  # the velocity loop of the drive, and its nominal loop
    # the compensator's tuned parameters by name, in the order of law.toml, with the standard errors
    # of their identification, SI units
    start: Mapping[str, Estimate]
    v_cmd: Array  # (n,) training command [m/s], one value a sample
    feed: Feed = "nominal"
    seed: int = 0  # of the small changes between repeated runs

    @cached_property
    def space(self) -> ParameterSpace:
        """The coordinates of the compensator's parameters."""
        return ParameterSpace.of(self.rig.law)

    def parameters(self, values: Array) -> dict[str, float]:
        """Return the genes' values (k,) by name."""
        return dict(zip(self.start, values.tolist(), strict=True))

    def cost_without(self) -> float:
        """Return the cost of the training run without compensation [m^2/s^2]."""
        criterion = VelocityCost(self.rig.T_s)
        any_values = np.array([one.value for one in self.start.values()])
        with self.rig.cost_of(
            self.v_cmd, self.loop, criterion, self.feed, compensated=False
        ) as cost:
            return cost(any_values)


def genes(start: Mapping[str, Estimate]) -> list[ga.Gene]:
    """Return the genes: identified values to start from, and the bounds of the paper."""
    low, high = BOUNDS
    return [
        ga.Gene(name, low * one.value, high * one.value, one.value, unit=unit_of(name))
        for name, one in start.items()
    ]
