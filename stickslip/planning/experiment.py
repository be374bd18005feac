"""One experiment of several parts, within limits."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
import pandas as pd

from stickslip.catalog.parameters import PAPER
from stickslip.errors import UsageError
from stickslip.planning import parts
from stickslip.planning.limits import LINEAR, Limits
from stickslip.servo.measurement import Array

REST = 0.01
"""Share of the whole in which the drive rests, before and after."""
FAVOUR = 4.0
"""How much more time a part gets that shows what is asked for."""


@dataclass(frozen=True)
class Part:
    """A kind of motion.

    Attributes
    ----------
    name : for people
    shows : parameters, by the paper's symbols
    weight : share of the time, relative to the others
    velocity : function (limits, n) -> (n,) [m/s]
    """

    name: str
    shows: tuple[str, ...]
    weight: float
    velocity: Callable[[Limits, int], Array]


PARTS = (
    Part("small moves", ("sigma_0", "sigma_1"), 3.0, parts.small_moves),
    Part("slow reversals", ("F_s", "v_s", "sigma_0"), 5.0, parts.slow_reversals),
    Part("constant speeds", ("b", "F_c"), 3.0, parts.constant_speeds),
    Part("quick ramps", ("m", "sigma_1"), 2.0, parts.quick_ramps),
    Part("sine sweep", ("m", "b", "F_c"), 7.0, parts.sweep),
)
"""In the order in which they run: small moves first, from rest, before the bristles are bent."""


@dataclass(frozen=True)
class Stretch:
    """Where a part lies in an experiment: from sample ``begin`` up to ``end``."""

    part: Part
    begin: int
    end: int


def arrange(limits: Limits = LINEAR, show: Collection[str] = ()) -> tuple[Stretch, ...]:
    """Return when which part runs; ``show`` names parameters whose parts get more time.

    Raises
    ------
    UsageError
        When ``show`` names no parameter.
    """
    for name in show:
        if name not in PAPER:
            raise UsageError(f"cannot show '{name}': expected one of {', '.join(PAPER)}")
    weights = [part.weight * (FAVOUR if set(part.shows) & set(show) else 1.0) for part in PARTS]
    n = round(limits.duration * limits.rate)
    rest = max(1, round(REST * n))
    edges = rest + (n - 2 * rest) * np.cumsum([0.0, *weights]) / sum(weights)
    edges = edges.round().astype(int)
    return tuple(
        Stretch(part, int(begin), int(end))
        for part, begin, end in zip(PARTS, edges[:-1], edges[1:], strict=True)
    )


def plan(limits: Limits = LINEAR, show: Collection[str] = ()) -> pd.DataFrame:
    """Return the command of an experiment that shows the parameters of a drive.

    Parameters
    ----------
    limits : what the drive may be asked to do
    show : parameters to favour, by the paper's symbols; none or all: a little of everything

    Returns
    -------
    pandas.DataFrame
        n = duration * rate + 1 rows; time [s], velocity_command [m/s], position_command [m]
        (rotary: rad/s, rad). The velocity starts and ends at 0 and the position where it began;
        speed, acceleration and stroke keep the limits. The position is the trapezoidal integral of
        the velocity, to 1e-15.

    Raises
    ------
    UsageError
        When ``show`` names no parameter.
    """
    velocity = np.zeros(round(limits.duration * limits.rate) + 1)
    for stretch in arrange(limits, show):
        samples = stretch.end - stretch.begin
        velocity[stretch.begin : stretch.end] = stretch.part.velocity(limits, samples)
    steps = 0.5 * (velocity[1:] + velocity[:-1]) / limits.rate
    position = np.concatenate([[0.0], np.cumsum(steps).round(15)])
    return pd.DataFrame(
        {
            "time": np.arange(len(velocity)) / limits.rate,
            "velocity_command": velocity,
            "position_command": position + 0.0,  # no -0
        }
    )
