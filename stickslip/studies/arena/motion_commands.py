"""The motions of the arena: one sweep to tune with, and others to validate with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim import Signal, SineSweep, Table
from stickslip.evaluation.motions import (
    BEGIN,
    REGION,
    VALIDATION,
    Motion,
    Span,
    Stroke,
    strokes,
    windows,
)
from stickslip.servo.measurement import Array

PASSES = 2  # Sweeps of the training command; the last one counts, when observers have settled
_SWEEP = SineSweep(frequency=(0.2, 1.0), amplitude=(0.03, 0.04), duration=5.0)
_REST = 0.3  # After each sweep, so that starts from rest count as well [s]
FIRST = (0.0, 0.1)
"""From when to when after a start or a reversal the errors of the trapezoid count [s]."""
SPEEDS = (1e-4, 3e-4, 1e-3, 3e-3)  # Of the creep [m/s]
CREEP, COUNTED = 2.0, 1.5  # How long each lasts, and the last part of it that counts [s]
RADIUS = 0.01  # Of the circles [m]
GLITCH = 0.3  # How far after a reversal the error of a circle counts [rad]
MOVES = {1e-6: 0.02, 2e-6: 0.02, 5e-6: 0.02, 1e-5: 0.02, 1e-4: 0.05, 1e-3: 0.2}
"""Lengths of the small moves [m], and how long each lasts [s]."""
TRAINING_MOVES = {1.5e-6: 0.02, 3e-6: 0.02, 7e-6: 0.02, 2e-5: 0.02, 5e-5: 0.05, 3e-4: 0.1}
"""As ``MOVES``, to tune what controls the position."""
SETTLING = 0.4  # Rest after each [s]
MOVE_POINTS = 200
HOLD = (2.0, 5.0)  # From when to when after a stop the rest counts [s]


@dataclass(frozen=True)
class Command:
    """A motion, and which errors of it count.

    Attributes
    ----------
    name, title : short name, and display name
    kind : what is measured on it, one of ``metrics.MEASURES``
    counted : spans of the motion's regions, by name, whose mean square makes the ``error``
    relative : speed to which the error in a region is relative [m/s]
    position : whether it is followed by the position loop
    ranked : whether its error counts in the mean over all commands
    """

    name: str
    title: str
    kind: str
    motion: Motion
    counted: tuple[str, ...] = ()
    relative: Mapping[str, float] = field(default_factory=dict)
    position: bool = False
    ranked: bool = True

    def sample(self, T_s: float) -> Array:
        """Return the velocities (n,) [m/s], one a sample."""
        n = round(self.motion.duration / T_s) + 1
        return self.motion.command.sample(np.asarray(np.arange(n) * T_s))

    def scaled(self, factor: float) -> Command:
        """Return the command with all velocities and lengths times a factor."""
        if factor == 1.0:
            return self
        motion = replace(self.motion, command=_Scaled(self.motion.command, factor))
        relative = {name: factor * speed for name, speed in self.relative.items()}
        return replace(self, motion=motion, relative=relative)


@dataclass(frozen=True)
class _Scaled:
    """A signal times a factor."""

    signal: Signal
    factor: float

    def sample(self, t: Array) -> Array:
        """Return the values (n,) at the times t (n,) [s]."""
        return np.asarray(self.factor * self.signal.sample(t))


@dataclass(frozen=True)
class Training:
    """A motion to tune with."""

    v_cmd: Array  # (n,) [m/s], one a sample
    counted: NDArray[np.bool_]  # (n,) whether the error of a sample counts


def moves(T_s: float, factor: float = 1.0) -> Training:
    """Return small moves, whose rests count in the last pass, for what controls the position."""
    motion = _small_moves(TRAINING_MOVES).motion
    t = np.asarray(np.arange(round(motion.duration / T_s)) * T_s)
    spans = [span for spans in motion.regions.values() for span in spans]
    rests = np.any([(t >= begin) & (t < end) for begin, end in spans], axis=0)
    v_cmd = np.tile(factor * motion.command.sample(t), PASSES)
    return Training(v_cmd, np.append(np.zeros((PASSES - 1) * len(t), bool), rests))


def sweep(T_s: float, factor: float = 1.0) -> Training:
    """Return a slow sweep, whose last pass counts, times a factor.

    What learns while it runs needs reversals that last longer than the loop takes to answer, which
    those of the paper's sweep to 5 Hz do not.
    """
    n = round((_SWEEP.duration + _REST) / T_s)
    v_cmd = factor * np.tile(_SWEEP.sample(np.asarray(np.arange(n) * T_s)), PASSES)
    return Training(v_cmd, np.arange(PASSES * n) >= (PASSES - 1) * n)


def _trapezoid() -> Command:
    spans: dict[str, tuple[Span, ...]] = {}
    for name, instant in windows(VALIDATION).items():
        for begin, end in (FIRST, REGION):
            label = f"{name} {round(1e3 * begin)}-{round(1e3 * end)} ms"
            spans[label] = ((instant + begin, instant + end),)
    duration = float(VALIDATION.corners()[-1] + VALIDATION.begin)
    motion = Motion("trapezoid", "The paper’s trapezoid", VALIDATION, duration, spans)
    whole = f"{round(1e3 * FIRST[0])}-{round(1e3 * FIRST[1])} ms"
    return Command(
        "T", "trapezoid", "velocity", motion, tuple(name for name in spans if name.endswith(whole))
    )


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
    return Command(
        "V", "creep", "velocity", motion, tuple(spans), dict(zip(spans, SPEEDS, strict=True))
    )


def _reversals() -> Command:
    moves = [("reversals", Stroke(sign * 5e-4, 0.25, 0.0, 0.0, 0.5)) for sign in 4 * (1, -1)]
    motion = strokes(
        "reversals", "A triangle of the velocity, ±0.5 mm/s with a period of 1 s", moves
    )
    return Command("R", "slow reversals", "velocity", motion, ("reversals",))


@dataclass(frozen=True)
class _Circles:
    """Velocity of one axis on circles that begin at its end: R w sin(w t), one after the other."""

    parts: tuple[tuple[float, float], ...]  # angular frequency [rad/s] and periods

    def sample(self, t: Array) -> Array:
        """Return the velocity (n,) [m/s] at times (n,) [s]."""
        v, begin = np.zeros(len(t)), BEGIN
        for w, periods in self.parts:
            end = begin + periods * 2.0 * np.pi / w
            inside = (t >= begin) & (t < end)
            v[inside] = RADIUS * w * np.sin(w * (t[inside] - begin))
            begin = end
        return v

    def reversals(self) -> dict[str, list[float]]:
        """Return the times of the reversals by circle [s], the first move aside."""
        found, begin = {}, BEGIN
        for w, periods in self.parts:
            half = np.pi / w
            last = int(2.0 * periods - GLITCH / np.pi)
            found[f"{w:g} rad/s"] = [begin + k * half for k in range(1, last + 1)]
            begin += 2.0 * periods * half
        return found


def _circles() -> Command:
    circles = _Circles(((4.0, 2.0), (1.0, 1.1)))
    spans: dict[str, tuple[Span, ...]] = {}
    for (w, _), (name, times) in zip(circles.parts, circles.reversals().items(), strict=True):
        spans[name] = tuple((t, t + GLITCH / w) for t in times)
    duration = BEGIN + sum(periods * 2.0 * np.pi / w for w, periods in circles.parts)
    motion = Motion("circle", "One axis of a circle", circles, duration, spans)
    return Command("C", "circle", "circle", motion, position=True)


def _smooth_moves(
    moves: Sequence[tuple[float, float]], rest: float
) -> tuple[Table, list[tuple[float, float, float]]]:
    """Return a table of moves (distance [m], duration [s]) with 1 - cos as velocity, and rests.

    Also the distance, and the times at which each move and its rest end [s].
    """
    times, values, ends = [np.zeros(1)], [np.zeros(1)], []
    now = BEGIN
    share = np.arange(MOVE_POINTS + 1) / MOVE_POINTS
    for distance, duration in moves:
        times.append(now + duration * share)
        values.append(distance / duration * (1.0 - np.cos(2.0 * np.pi * share)))
        ends.append((distance, now + duration, now + duration + rest))
        now += duration + rest
    return Table(np.concatenate(times), np.concatenate(values)), ends


def _small_moves(lengths: Mapping[float, float]) -> Command:
    """Return moves there and back, by length [m] and how long it lasts [s]."""
    pairs = [(sign * length, lasts) for length, lasts in lengths.items() for sign in (1.0, -1.0)]
    table, ends = _smooth_moves(pairs, SETTLING)
    spans: dict[str, tuple[Span, ...]] = {}
    for distance, stopped, settled in ends:
        name = f"{1e6 * abs(distance):g} um"
        spans[name] = (*spans.get(name, ()), (stopped, settled))
    motion = Motion("moves", "Small moves and rests", table, ends[-1][2], spans)
    return Command("M", "small moves", "settling", motion, position=True)


def _hold() -> Command:
    table, ((_, stopped, _),) = _smooth_moves([(1e-3, 0.2)], HOLD[1])
    spans = {"hold": ((stopped + HOLD[0], stopped + HOLD[1]),)}
    motion = Motion("hold", "Rest after a stop", table, stopped + HOLD[1], spans)
    return Command("H", "hold", "hunting", motion, position=True, ranked=False)


def _inner_loops() -> Command:
    corners = (0.0, 4e-5, 0.0, 1.5e-5, 0.0, -4e-5, 0.0)
    moves = [(float(step), 0.1) for step in np.diff(corners)]
    table, ends = _smooth_moves(moves, 0.1)
    spans = {"path": ((BEGIN, ends[-1][2]),)}
    motion = Motion("inner loops", "A path with inner loops", table, ends[-1][2], spans)
    return Command("P", "inner loops", "path", motion, position=True)


COMMANDS = {
    command.name: command
    for command in (
        *(_trapezoid(), _creep(), _reversals()),
        *(_circles(), _small_moves(MOVES), _hold(), _inner_loops()),
    )
}
"""What entrants are validated with; none of it is tuned on."""
