"""Whether a compensator helps, and at which share of its force it never makes the loop worse.

It is tried at the command's speed, a tenth and a hundredth of it, on drives whose friction is as
fitted, without its rise towards rest, half of it, and half as much again. Where friction has
halved, exact feedforward leaves an error like that without it, or a larger one; a share of 0.85 to
0.9 of its force then leaves less, and hardly more on the fitted drive.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace

import numpy as np

from stickslip.catalog.space import ParameterSpace
from stickslip.evaluation.guards.trial import Trial

WORSE = 1.02
"""Largest ratio of the error with the compensator to that without it."""
SPEEDS = (1.0, 0.1, 0.01)
SHARES = (1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5)


@dataclass(frozen=True)
class Tried:
    """RMS of v - v_cmd [m/s] on one simulated drive, without and with the compensator.

    Attributes
    ----------
    speed : largest of the command [m/s]
    drive : how its friction differs from the fitted one
    """

    speed: float
    drive: str
    without: float
    compensated: float

    @property
    def ratio(self) -> float:
        """How many times larger the error is by the compensator; infinite if not finite."""
        if not math.isfinite(self.compensated) or not self.without > 0.0:
            return math.inf
        return self.compensated / self.without


@dataclass(frozen=True)
class Benefit:
    """What a compensator does to the tracking error.

    Attributes
    ----------
    share : of the compensator's force; the largest of ``SHARES`` that is acceptable, or 1
    rows : at that share, one for each speed and drive
    full : the same at the whole force
    unit : of a thousandth of a speed, for people
    """

    share: float
    rows: tuple[Tried, ...]
    full: tuple[Tried, ...]
    unit: str = "mm/s"

    @property
    def acceptable(self) -> bool:
        """Whether the error is nowhere worse with the compensator than without it."""
        return all(row.ratio <= WORSE for row in self.rows)

    @property
    def reason(self) -> str:
        """Where the whole force makes the error grow most."""
        worst = max(self.full, key=lambda row: row.ratio)
        return (
            f"with the whole force the simulated tracking error at {1e3 * worst.speed:.3g}"
            f" {self.unit} on a drive with {worst.drive} is {1e3 * worst.compensated:.3g}"
            f" {self.unit}, {worst.ratio:.3g} times that without the compensator"
        )

    @property
    def refusal(self) -> str:
        """Why a compensator that is not acceptable is refused, and what to do."""
        return (
            f"{self.reason}; expected at most {WORSE:g} times, and no share of the force down to"
            f" {SHARES[-1]:g} keeps that; raise K_p, learn from a log that shows more, or"
            " compensate faster commands only"
        )


def benefit_of(trial: Trial, *, rotary: bool = False) -> Benefit:
    """Try a compensator at every speed and on every drive, with the largest acceptable share."""
    unit = "mrad/s" if rotary else "mm/s"
    cells = list(_cells(trial))
    with ExitStack() as stack:
        without = [_without(cell) for _, _, cell in cells]
        runs = [stack.enter_context(cell.runs(compensated=True)) for _, _, cell in cells]

        def tried(share: float) -> tuple[Tried, ...]:
            compensator = trial.law.share(trial.compensator, share)
            return tuple(
                Tried(speed, name, error, run.error(compensator))
                for (speed, name, _), error, run in zip(cells, without, runs, strict=True)
            )

        full = tried(1.0)
        for share in SHARES:
            benefit = Benefit(share, full if share == 1.0 else tried(share), full, unit)
            if benefit.acceptable:
                return benefit
    return Benefit(1.0, full, full, unit)


def _cells(trial: Trial) -> Iterator[tuple[float, str, Trial]]:
    top = float(np.abs(trial.v_cmd).max())
    for speed in SPEEDS:
        for name, friction in _drives(trial).items():
            yield speed * top, name, replace(trial, friction=friction, v_cmd=speed * trial.v_cmd)


def _drives(trial: Trial) -> dict[str, Mapping[str, float]]:
    friction, law = trial.friction, trial.law
    bounded = ParameterSpace.of(law).bounded.items()
    level = {f"{name} = {bound}": {**friction, name: friction[bound]} for name, bound in bounded}
    return {
        "friction as fitted": friction,
        **level,
        "friction x 0.5": law.share(friction, 0.5),
        "friction x 1.5": law.share(friction, 1.5),
    }


def _without(trial: Trial) -> float:
    with trial.runs(compensated=False) as run:
        return run.error()
