"""The motions of the arena: one sweep to tune with, and others to validate with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stickslip.cosim import SineSweep, Table
from stickslip.evaluation.motions import BEGIN, Motion, Span, Stroke, strokes, windows
from stickslip.servo.datasheet import REGION, VALIDATION
from stickslip.servo.measurement import Array

PASSES = 2
"""Sweeps of the training command; the last one counts, when observers have settled."""
_SWEEP = SineSweep(frequency=(0.2, 1.0), amplitude=(0.03, 0.04), duration=5.0)
_REST = 0.3
"""After each sweep, so that starts from rest count as well [s]."""
FIRST = (0.0, 0.1)
"""From when to when after a start or a reversal the errors of the trapezoid count [s]."""
SPEEDS = (1e-4, 3e-4, 1e-3, 3e-3)
"""Of the creep [m/s]."""
CREEP, COUNTED = 2.0, 1.5
"""How long each lasts, and the last part of it that counts [s]."""


@dataclass(frozen=True)
class Command:
    """A motion, and which errors of it count.

    Attributes
    ----------
    name, title : short, and for people
    counted : spans of the motion's regions, by name, whose mean square makes the ``error``
    relative : speed to which the error in a region is relative [m/s]
    """

    name: str
    title: str
    motion: Motion
    counted: tuple[str, ...]
    relative: Mapping[str, float] = field(default_factory=dict)

    @property
    def unit(self) -> str:
        """Unit of the ``error``."""
        return "1" if self.relative else "m/s"

    def sample(self, T_s: float) -> Array:
        """Return the velocities (n,) [m/s], one a sample."""
        n = round(self.motion.duration / T_s) + 1
        return self.motion.command.sample(np.asarray(np.arange(n) * T_s))


def training(T_s: float) -> Array:
    """Return the command (n,) [m/s] with which entrants are tuned.

    A slow sweep: what learns while it runs needs reversals that last longer than the loop takes to
    answer, which those of the paper's sweep to 5 Hz do not.
    """
    n = round((_SWEEP.duration + _REST) / T_s)
    return np.tile(_SWEEP.sample(np.asarray(np.arange(n) * T_s)), PASSES)


def _trapezoid() -> Command:
    spans: dict[str, tuple[Span, ...]] = {}
    for name, instant in windows(VALIDATION).items():
        for begin, end in (FIRST, REGION):
            label = f"{name} {round(1e3 * begin)}-{round(1e3 * end)} ms"
            spans[label] = ((instant + begin, instant + end),)
    duration = float(VALIDATION.corners()[-1] + VALIDATION.begin)
    motion = Motion("trapezoid", "The paper’s trapezoid", VALIDATION, duration, spans)
    whole = f"{round(1e3 * FIRST[0])}-{round(1e3 * FIRST[1])} ms"
    return Command("T", "trapezoid", motion, tuple(name for name in spans if name.endswith(whole)))


def _creep() -> Command:
    time, v = [0.0, BEGIN], [0.0, 0.0]
    spans: dict[str, tuple[Span, ...]] = {}
    for speed in SPEEDS:
        end = time[-1] + CREEP
        spans[f"{1e3 * speed:g} mm/s"] = ((end - COUNTED, end),)
        time += [time[-1], end, end, end + BEGIN]
        v += [speed, speed, 0.0, 0.0]
    motion = Motion(
        "creep", "Constant low speeds", Table(np.array(time), np.array(v)), time[-1], spans
    )
    return Command("V", "creep", motion, tuple(spans), dict(zip(spans, SPEEDS, strict=True)))


def _reversals() -> Command:
    moves = [("reversals", Stroke(sign * 5e-4, 0.25, 0.0, 0.0, 0.5)) for sign in 4 * (1, -1)]
    motion = strokes(
        "reversals", "A triangle of the velocity, ±0.5 mm/s with a period of 1 s", moves
    )
    return Command("R", "slow reversals", motion, ("reversals",))


COMMANDS = {command.name: command for command in (_trapezoid(), _creep(), _reversals())}
"""What entrants are validated with; none of it is tuned on."""
