"""The motions of the arena: those to tune with, and others of the same kinds to validate with."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from stickslip.cosim import SineSweep, Table
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

PASSES = 2  # Sweeps in which an entrant learns that learns while it runs
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
SETTLING = 0.4  # Rest after each [s]
MOVE_POINTS = 200
HOLD = (2.0, 5.0)  # From when to when after a stop the rest counts [s]


@dataclass(frozen=True)
class Command:
    """A motion, and which errors of it count."""

    name: str
    title: str  # display name
    kind: str  # what is measured on it, one of ``metrics.MEASURES``
    motion: Motion
    counted: tuple[str, ...] = ()  # regions of the motion whose mean square makes the ``error``
    relative: Mapping[str, float] = field(default_factory=dict)  # [m/s]: of the error in a region
    position: bool = False  # whether it is followed by the position loop
    ranked: bool = True  # whether its error counts in the mean over all commands

    def sample(self, T_s: float) -> Array:
        """Return the velocities (n,) [m/s], one a sample."""
        n = round(self.motion.duration / T_s) + 1
        return self.motion.command.sample(np.asarray(np.arange(n) * T_s))

    def scaled(self, factor: float) -> "Command":
        """Return the command with all velocities and lengths times a factor."""
        if factor == 1.0:
            return self
        signal = self.motion.command
        motion = replace(self.motion, command=_Signal(lambda t: factor * signal.sample(t)))
        relative = {name: factor * speed for name, speed in self.relative.items()}
        return replace(self, motion=motion, relative=relative)


@dataclass(frozen=True)
class _Signal:
    """A signal by a function of times (n,) [s]."""

    function: Callable[[Array], object]

    def sample(self, t: Array) -> Array:
        """Return the values (n,) at the times t (n,) [s]."""
        return np.asarray(self.function(t))


def _sweep(passes: int = 1) -> Command:
    """Return slow sweeps, of which the start and the reversals count.

    What learns while it runs needs reversals that last longer than the loop takes to answer, which
    those of the paper's sweep to 5 Hz do not.
    """
    period = _SWEEP.duration + _REST
    t = np.asarray(np.arange(round(_SWEEP.duration / 1e-3)) * 1e-3)
    turns = t[:-1][np.diff(np.sign(_SWEEP.sample(t))) != 0.0]
    spans = {"start and reversals": tuple((float(turn), float(turn) + FIRST[1]) for turn in turns)}
    sweeps = _Signal(lambda t: _SWEEP.sample(np.mod(t, period)))
    motion = Motion("sweep", "Sweep of 0.2 to 1 Hz", sweeps, passes * period, spans)
    return Command("sweep", "sweep", "velocity", motion, tuple(spans))


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


def _creep(speeds: Sequence[float] = SPEEDS, lasts: float = CREEP) -> Command:
    time, v = [0.0, BEGIN], [0.0, 0.0]
    spans: dict[str, tuple[Span, ...]] = {}
    for speed in speeds:
        end = time[-1] + lasts
        spans[f"{1e3 * speed:g} mm/s"] = ((end - COUNTED / CREEP * lasts, end),)
        time += [time[-1], end, end, end + BEGIN]
        v += [speed, speed, 0.0, 0.0]
    motion = Motion(
        "creep", "Constant low speeds", Table(np.array(time), np.array(v)), time[-1], spans
    )
    return Command(
        "V", "creep", "velocity", motion, tuple(spans), dict(zip(spans, speeds, strict=True))
    )


def _reversals(speed: float = 5e-4, rise: float = 0.25, pairs: int = 4) -> Command:
    stroke = Stroke(speed, rise, 0.0, 0.0, 2.0 * rise)
    moves = [("reversals", replace(stroke, speed=sign * speed)) for sign in pairs * (1, -1)]
    text = f"A triangle of the velocity, ±{1e3 * speed:g} mm/s with a period of {4.0 * rise:g} s"
    motion = strokes("reversals", text, moves)
    return Command("R", "slow reversals", "velocity", motion, ("reversals",))


def _circles(*parts: tuple[float, float]) -> Command:
    """Return one axis of circles, of angular frequency w [rad/s] and periods, one after the other.

    Each begins at the end of the axis: its velocity is R w sin(w t).
    """
    ends, spans = [BEGIN], dict[str, tuple[Span, ...]]()
    for w, periods in parts:
        turns = int(2.0 * periods - GLITCH / np.pi)
        times = [ends[-1] + k * (np.pi / w) for k in range(1, turns + 1)]  # but the first move
        spans[f"{w:g} rad/s"] = tuple((t, t + GLITCH / w) for t in times)
        ends.append(ends[-1] + periods * 2.0 * np.pi / w)

    def velocity(t: Array) -> Array:
        v = np.zeros(len(t))
        for (w, _), (begin, end) in zip(parts, pairwise(ends), strict=True):
            inside = (t >= begin) & (t < end)
            v[inside] = RADIUS * w * np.sin(w * (t[inside] - begin))
        return v

    motion = Motion("circle", "One axis of a circle", _Signal(velocity), ends[-1], spans)
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


def _inner_loops(*corners: float) -> Command:
    moves = [(float(step), 0.1) for step in np.diff(corners)]
    table, ends = _smooth_moves(moves, 0.1)
    spans = {"path": ((BEGIN, ends[-1][2]),)}
    motion = Motion("inner loops", "A path with inner loops", table, ends[-1][2], spans)
    return Command("P", "inner loops", "path", motion, position=True)


COMMANDS = {
    command.name: command
    for command in (
        *(_trapezoid(), _creep(), _reversals()),
        *(_circles((4.0, 2.0), (1.0, 1.1)), _small_moves(MOVES), _hold()),
        _inner_loops(0.0, 4e-5, 0.0, 1.5e-5, 0.0, -4e-5, 0.0),
    )
}
"""What entrants are validated with; none of it is tuned on."""
TRAINING = (
    _sweep(),
    _creep((2e-4, 2e-3), 0.8),
    _reversals(7e-4, 0.2, 2),
    _circles((3.0, 1.2)),
    _small_moves({3e-6: 0.02, 2e-5: 0.02, 3e-4: 0.1}),
    _inner_loops(0.0, 3e-5, -1e-5, 2e-5, 0.0),
)
"""What entrants are tuned on: each kind of motion that is ranked, at other speeds and lengths."""
LEARNING = _sweep(PASSES)
"""What teaches an entrant that learns while it runs."""
