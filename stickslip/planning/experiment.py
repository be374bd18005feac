"""One experiment of several parts, within limits."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.catalog.parameters import PAPER
from stickslip.errors import UsageError
from stickslip.planning import parts
from stickslip.planning.parts import LINEAR, Limits
from stickslip.servo.measurement import Array

if TYPE_CHECKING:
    import pandas as pd

REST = 0.01  # share of the whole in which the drive rests, before and after
ROUNDS = 4
FAVOUR = 4.0  # how much more time a part gets that shows what is asked for


@dataclass(frozen=True)
class Part:
    """A kind of motion."""

    name: str  # display name
    shows: tuple[str, ...]  # parameters, by the paper's symbols
    weight: float  # share of the time, relative to the others
    velocity: Callable[[Limits, int], Array]  # function (limits, n) -> (n,) [m/s]


PARTS = (
    Part("small moves", ("sigma_0", "sigma_1"), 2.5, parts.small_moves),
    Part("creep", ("F_s", "v_s"), 7.0, parts.creep),
    Part("constant speeds", ("b", "F_c"), 3.0, parts.constant_speeds),
    Part("quick ramps", ("m", "sigma_1"), 2.0, parts.quick_ramps),
    Part("sine sweep", ("m", "b", "F_c"), 5.5, parts.sweep),
)
"""In the order in which they run: small moves first, from rest, before the bristles are bent."""
WHOLE = Part("whole travel", ("position_force",), 1.5, parts.whole_travel)
"""Last, where it is asked for."""
SHOWN = (*PAPER, *WHOLE.shows)

SET = {"presliding": PARTS[:1], "creep": PARTS[1:2], "sliding": PARTS[2:]}
"""Parts by the name of an experiment, where each kind of motion has one of its own."""


@dataclass(frozen=True)
class Stretch:
    """Where a part lies in an experiment: from sample ``begin`` up to ``end``."""

    part: Part
    begin: int
    end: int


def arrange(
    limits: Limits = LINEAR, show: Collection[str] = (), among: Sequence[Part] = PARTS
) -> tuple[Stretch, ...]:
    """Return when which part runs; those that show what is asked for get more time."""
    return _laid_out(limits, show, among)[0]


def plan(
    limits: Limits = LINEAR, show: Collection[str] = (), among: Sequence[Part] = PARTS
) -> pd.DataFrame:
    """Return the command of an experiment that shows the parameters of a drive.

    Parameters
    ----------
    limits : what the drive may be asked to do
    show : parameters to favour, by the paper's symbols, and ``position_force`` for gravity and
        cogging, which the whole travel shows; none: a little of every parameter
    among : parts of which it consists

    Returns
    -------
    pandas.DataFrame
        n = duration * rate + 1 rows; time [s], velocity_command [m/s], position_command [m]
        (rotary: rad/s, rad). The velocity starts and ends at 0 and the position where it began;
        speed, acceleration, jerk, stroke and travel keep the limits. The position is the
        trapezoidal integral of the velocity, to 1e-15.

    Raises
    ------
    UsageError
        When ``show`` names no parameter, or the way into the travel takes too long.
    """
    import pandas as pd  # late, for those who start quickly

    velocity = _laid_out(limits, show, among)[1]
    steps = 0.5 * (velocity[1:] + velocity[:-1]) / limits.rate
    position = np.concatenate([[0.0], np.cumsum(steps).round(15)])
    return pd.DataFrame(
        {
            "time": np.arange(len(velocity)) / limits.rate,
            "velocity_command": velocity,
            "position_command": position + 0.0,  # no -0
        }
    )


def _laid_out(
    limits: Limits, show: Collection[str], among: Sequence[Part]
) -> tuple[tuple[Stretch, ...], Array]:
    """Return the stretches and the velocity (n,).

    Where the range that the parts need does not lie around the start, the drive first moves to
    where it does, and back at the end.
    """
    for name in [show] if isinstance(show, str) else show:
        if name not in SHOWN or isinstance(show, str):
            raise UsageError(f"cannot show {show!r}: expected a list of {', '.join(SHOWN)}")
    n = round(limits.duration * limits.rate)
    rest = max(1, round(REST * n))
    least = 0
    for _ in range(ROUNDS):
        stretches = _stretches(show, n, max(rest, least), among)
        velocity = np.zeros(n + 1)
        for one in stretches:
            samples = one.end - one.begin
            velocity[one.begin : one.end] = one.part.velocity(limits, samples)
        velocity, offset = _placed(velocity, limits)
        move = parts.approach(limits, offset)
        if not offset:
            return stretches, velocity
        begin, end = stretches[0].begin, stretches[-1].end
        if len(move) <= min(begin - 1, n - end):
            velocity[1 : 1 + len(move)] += move
            velocity[end + 1 : end + 1 + len(move)] -= move
            return stretches, velocity
        least = len(move) + 2
        if 4 * least > n:
            break
    raise UsageError(
        f"travel = {limits.travel[0]:g} to {limits.travel[1]:g}: the move to where the parts fit "
        "takes too long; start nearer to an end, or plan a longer experiment"
    )


def _stretches(
    show: Collection[str], n: int, rest: int, among: Sequence[Part]
) -> tuple[Stretch, ...]:
    crosses = PARTS[-1] in among and set(WHOLE.shows) & set(show)
    every = (*among, WHOLE) if crosses else among
    weights = [part.weight * (FAVOUR if set(part.shows) & set(show) else 1.0) for part in every]
    edges = rest + (n - 2 * rest) * np.cumsum([0.0, *weights]) / sum(weights)
    edges = edges.round().astype(int)
    return tuple(
        Stretch(part, int(begin), int(end))
        for part, begin, end in zip(every, edges[:-1], edges[1:], strict=True)
    )


def _placed(velocity: Array, limits: Limits) -> tuple[Array, float]:
    """Return the velocity, or its mirror image, and the least offset [m] that keeps the travel."""
    x = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1])) / limits.rate])
    low, high = limits.travel
    choices = []
    for sign in (1.0, -1.0):
        least, most = (sign * x).min(), (sign * x).max()
        choices.append((float(np.clip(0.0, low - least, high - most)), sign))
    offset, sign = min(choices, key=lambda choice: abs(choice[0]))
    return sign * velocity, offset
