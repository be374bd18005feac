"""The motions of the validation: the paper's trapezoid, and three that show what it does not.

Friction depends on F_s and v_s only at speeds of a few v_s, and on sigma_0 and sigma_1 only within
some break-away deflections F_s / sigma_0 of a start or a reversal. The errors of the trapezoid are
taken at 1.6 to 3.9 mm/s; the other motions are slower or shorter. Commands and regions are the same
for every drive. Why these: docs/decisions/0041-motions-that-test-all-five.md.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from stickslip import cosim
from stickslip.cosim import SineSweep, Trapezoid

TRAINING = SineSweep(frequency=(0.1, 5.0), amplitude=(0.030, 0.040), duration=10.0)
"""The training command of section 4.2 [m/s]."""

SLOW = SineSweep(frequency=(0.1, 0.5), amplitude=(0.030, 0.040), duration=10.0)
"""Reversals slower than nearly all of the training command, to compare results of it on [m/s]."""

VALIDATION = Trapezoid(height=0.040, slope=0.055, plateau=0.5, begin=0.1)
"""The trapezoid of Fig. 6(a) [m/s]."""

REGION = (0.030, 0.070)  # evaluated windows after motion starts or reverses, from when to when [s]

Span = tuple[float, float]  # from when to when [s]
Regions = Mapping[str, tuple[Span, ...]]  # by name, the spans of time over which errors are taken


@dataclass(frozen=True)
class Motion:
    """A velocity command, and where the errors of following it are taken."""

    name: str  # such as ``creep``
    purpose: str  # one sentence on what it tests and which samples count
    command: cosim.Signal  # [m/s]
    duration: float  # [s]
    regions: Regions  # the spans that count
    positioned: bool = False  # whether the position error counts as well


@dataclass(frozen=True)
class Stroke:
    """A move with constant acceleration up to a speed and down to rest."""

    speed: float  # with sign [m/s]
    ramp: float  # how long each ramp lasts [s]
    hold: float  # how long the constant speed lasts [s]
    rest: float  # how long the rest after it lasts [s]
    counted: float  # how long after its begin the errors are taken [s]


BEGIN = 0.1  # rest before the first stroke [s]


def windows(command: cosim.Trapezoid) -> dict[str, float]:
    """Return the instants [s] at which the motion starts and reverses."""
    corners = command.corners()
    return {"start": float(corners[0]), "reverse": float(corners[2:4].mean())}


def regions_after(instants: Mapping[str, float]) -> dict[str, tuple[Span, ...]]:
    """Return for each of these instants [s] the ``REGION`` after it."""
    return {name: ((t + REGION[0], t + REGION[1]),) for name, t in instants.items()}


def trapezoid(command: cosim.Trapezoid) -> Motion:
    """Return the motion of section 4.2 of the paper."""
    begin, end = (round(1e3 * edge) for edge in REGION)
    return Motion(
        "trapezoid",
        f"The paper’s motion, {begin} to {end} ms after it starts or reverses; it shows Coulomb "
        "friction.",
        command,
        float(command.corners()[-1] + command.begin),
        regions=regions_after(windows(command)),
    )


def strokes(
    name: str, purpose: str, moves: Iterable[tuple[str, Stroke]], *, positioned: bool = False
) -> Motion:
    """Return a motion of strokes one after another, each with the name of its region."""
    time, v = [0.0, BEGIN], [0.0, 0.0]
    regions: dict[str, tuple[Span, ...]] = {}
    for region, move in moves:
        begin = time[-1]
        regions[region] = (*regions.get(region, ()), (begin, begin + move.counted))
        for lasts, reached in (
            (move.ramp, move.speed),
            (move.hold, move.speed),
            (move.ramp, 0.0),
            (move.rest, 0.0),
        ):
            if lasts > 0.0:
                time.append(time[-1] + lasts)
                v.append(reached)
    return Motion(
        name,
        purpose,
        cosim.Table(np.array(time), np.array(v)),
        time[-1] + BEGIN,
        regions=regions,
        positioned=positioned,
    )


def _reversals() -> Motion:
    """Return two periods of 1 s of a triangle at each of two amplitudes."""
    quarter = 0.25
    moves = [
        (f"{1e3 * speed:g} mm/s", Stroke(sign * speed, quarter, 0.0, 0.0, counted=quarter))
        for speed in (5e-4, 2e-3)
        for sign in 2 * (1, -1)
    ]
    return strokes(
        "slow reversals",
        "The velocity runs on straight lines between peaks of ±0.5 mm/s and then of ±2 mm/s, with "
        "a period of 1 s; errors are taken from each crossing of zero to the next peak. It shows "
        "how friction rises and falls again after a reversal.",
        moves,
        positioned=True,
    )


def _creep() -> Motion:
    """Return a stroke forward and one back at each of four speeds."""
    length, ramp, rest = 2e-4, 5e-3, 0.1
    moves = []
    for speed in (1e-4, 3e-4, 1e-3, 2e-3):
        lasts = length / speed + ramp
        for sign in (1, -1):
            move = Stroke(sign * speed, ramp, lasts - 2 * ramp, rest, counted=lasts)
            moves.append((f"{1e3 * speed:g} mm/s", move))
    return strokes(
        "creep",
        "Strokes of 200 µm forward and back at a constant speed, reached in 5 ms; errors are taken "
        "while the command moves. It shows break-away and the friction of low speeds.",
        moves,
    )


def _micrometre_moves() -> Motion:
    """Return moves forward and back, twice each, over three distances."""
    half, rest = 0.025, 0.1
    moves = [
        (
            f"{1e6 * distance:g} um",
            Stroke(sign * distance / half, half, 0.0, rest, counted=2 * half + rest),
        )
        for distance in (5e-6, 2e-5, 5e-5)
        for sign in 2 * (1, -1)
    ]
    return strokes(
        "micrometre moves",
        "Moves of 5, 20 and 50 µm forward and back in 50 ms each, below and above the deflection "
        "at which the contact of the paper’s drive breaks away, 23 µm; errors are taken over each "
        "move and the 100 ms of rest after it. It shows stiffness and damping of the bristles.",
        moves,
        positioned=True,
    )


SLOW_MOTIONS = (_reversals(), _creep(), _micrometre_moves())  # slower than the trapezoid
MOTIONS = (trapezoid(VALIDATION), *SLOW_MOTIONS)  # all of them, the paper's first
