"""Limits of an experiment, and the parts of its velocity command."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from numbers import Real

import numpy as np

from stickslip.errors import UsageError
from stickslip.servo.measurement import Array
from stickslip.thresholds import experiment


def _is_like(value: object, model: object) -> bool:
    """Whether a value is a number, or as many numbers as another."""
    if isinstance(model, tuple):
        return (
            isinstance(value, tuple | list)
            and len(value) == len(model)
            and all(map(_is_like, value, model))
        )
    return isinstance(value, Real)


@dataclass(frozen=True)
class Limits:
    """Bounds of an experiment; for a rotary drive read rad for m.

    Attributes
    ----------
    stroke : between the two farthest positions [m]
    speed : [m/s]
    acceleration : [m/s^2]
    jerk : [m/s^3]; infinite when it is not limited
    travel : lowest and highest position, from that at the begin [m]
    duration : of the whole experiment [s]
    rate : samples of the command per second [Hz]
    frequency : of the sweep, begin and end [Hz]; narrower where stroke and acceleration ask for it
    presliding : sizes of the smallest and the largest small move [m]

    Raises
    ------
    UsageError
        When a value is not positive, a range is upside down or too small for the smallest move,
        or there are too few samples.
    """

    stroke: float = 0.1
    speed: float = 0.04
    acceleration: float = 2.0
    duration: float = 20.0
    rate: float = 2000.0
    frequency: tuple[float, float] = (0.1, 5.0)
    presliding: tuple[float, float] = (1e-6, 1e-3)
    jerk: float = math.inf
    travel: tuple[float, float] = (-math.inf, math.inf)

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not _is_like(value, field.default):
                raise UsageError(
                    f"{field.name} = {value!r}: expected"
                    f" {'two numbers' if isinstance(field.default, tuple) else 'a number'}"
                )
            if field.name in ("jerk", "travel"):
                continue
            for number in value if isinstance(value, tuple) else (value,):
                if not (math.isfinite(number) and number > 0):
                    raise UsageError(f"{field.name} = {value}: expected more than 0")
            if isinstance(value, tuple) and value[0] > value[1]:
                raise UsageError(f"{field.name} = {value}: expected smallest, then largest")
        if not self.jerk > 0:
            raise UsageError(f"jerk = {self.jerk}: expected more than 0")
        low, high = self.travel
        if not low <= 0.0 <= high or not high > low:
            raise UsageError(f"travel = {low:g} to {high:g}: expected a range that contains 0")
        if self.room < self.presliding[0]:
            raise UsageError(
                f"stroke and travel leave {self.room:g} m or rad; expected at least"
                f" {self.presliding[0]:g}, the smallest of the small moves"
            )
        if self.duration < experiment.DURATION:
            raise UsageError(
                f"duration = {self.duration:g} s: expected at least {experiment.DURATION:g} s"
            )
        slowest, fastest = experiment.SLOWEST, experiment.FASTEST
        if not slowest <= self.rate <= fastest:
            raise UsageError(f"rate = {self.rate:g} Hz: expected {slowest:g} to {fastest:,.0f} Hz")
        if self.duration * self.rate > experiment.SAMPLES:
            raise UsageError(
                f"duration = {self.duration:g} s at rate = {self.rate:g} Hz: expected at most "
                f"{experiment.SAMPLES / 1e6:g} million samples; shorten it or lower the rate"
            )

    @property
    def room(self) -> float:
        """The longest distance [m] that stroke and travel permit."""
        return min(self.stroke, self.travel[1] - self.travel[0])

    @property
    def reachable(self) -> float:
        """The largest speed [m/s] of a move from rest to rest within the room."""
        return min(self.speed, math.sqrt(0.9 * self.acceleration * 0.95 * self.room))


LINEAR = Limits()  # suits the paper's stage: its training sweep fits

ROTARY = Limits(stroke=2 * math.pi, speed=2 * math.pi, acceleration=200.0, presliding=(1e-4, 0.1))
"""A motor shaft and one turn."""

QUICK = 0.1  # shortest move [s]: what most position loops still follow


def small_moves(limits: Limits, n: int) -> Array:
    """Return small moves out and back, from the smallest to the largest; each slow, then quick.

    Within the presliding range the slow ones show stiffness, the quick ones damping. How far that
    range goes nobody knows beforehand, so their sizes are a geometric series.
    """
    moves = max(1, min(max(4, round(n / limits.rate / 0.3)), n // 8))  # 4 samples a sine
    smallest, largest = limits.presliding
    sizes = np.geomspace(smallest, max(smallest, min(largest, limits.room / 4)), moves)
    pieces = []
    for size, room in zip(sizes, _shares(n, moves), strict=True):
        quick = min(room // 2, max(2, round(QUICK * limits.rate)))
        pieces += [
            _smooth(partial(_out_and_back, limits, size), limits, samples)
            for samples in (room - quick, quick)
        ]
    return np.concatenate(pieces)


CREEP = (0.004, 0.2)
"""Least and largest speed of the creep, as shares of the highest one."""
LEVEL_TIME = 0.5  # of each speed of the creep [s]
PLACES = 0.4  # share of the room over which they are spread
LEVEL = (
    (0.06, "move"), (0.2, "move"), (0.28, "creep"), (0.78, "creep"), (0.8, "rest"),
    (0.88, "rest"), (0.9, "creep"), (1.0, "creep"),
)  # fmt: skip
"""Corners of one speed of the creep: share of its time, and what is done there."""


def levels(duration: float) -> int:
    """Return the number of speeds in each direction of a creep that lasts so long [s]."""
    return max(3, round(0.5 * duration / LEVEL_TIME))


def slowest_creep(limits: Limits) -> float:
    """Return the lowest speed [m/s] of the creep."""
    return CREEP[0] * limits.reachable


def creep(limits: Limits, n: int) -> Array:
    """Return creep at speeds in a geometric series, the fastest first, forward and then back.

    Each speed is at another place. The drive slows down to it without a reversal, so that it slides
    at once; then it rests under the force that the loop holds, and breaks away again. A loop's
    integral then has only the rise of friction to cross, not all of it in the other direction.
    """
    duration = n / limits.rate
    fastest = CREEP[1] * limits.reachable
    move = min(fastest, PLACES * limits.room / (0.25 * duration))
    count = levels(duration)
    speeds = np.geomspace(fastest, slowest_creep(limits), count)
    time, v = [0.0], [0.0]
    for k, speed in enumerate(np.minimum(speeds, move)):
        kinds = {"move": move, "creep": float(speed), "rest": 0.0}
        time += [(k + share) / count for share, _ in LEVEL]
        v += [kinds[what] for _, what in LEVEL]
    v[-1] = 0.0
    half = _smooth(partial(_polygon, limits, 1.0, (time, v)), limits, n // 2)
    return np.concatenate([half, -half, np.zeros(n % 2)])


def constant_speeds(limits: Limits, n: int) -> Array:
    """Return trapezoids forward and back at speeds in a geometric series."""
    count = max(2, round(n / limits.rate / 1.0))
    speeds = np.geomspace(limits.speed, CREEP[1] * limits.speed, count)
    pieces = []
    for v, samples in zip(speeds, _shares(n, count), strict=True):
        corners = ([0, 0.1, 0.4, 0.6, 0.9, 1], [0, 1, 1, -1, -1, 0])
        pieces.append(_smooth(partial(_polygon, limits, v, corners), limits, samples))
    return np.concatenate(pieces)


CROSSING = 0.7  # mean speed over the whole travel, as a share of what is reached within it


def whole_travel(limits: Limits, n: int) -> Array:
    """Return runs over all of the travel and back."""
    length = 0.95 * limits.room
    once = max(QUICK, 2.0 * length / (CROSSING * limits.reachable))  # [s]
    pieces = []
    for samples in _shares(n, max(1, math.floor(n / limits.rate / once))):
        corners = ([0, 0.05, 0.45, 0.55, 0.95, 1], [0, 1, 1, -1, -1, 0])
        run = partial(_polygon, limits, length * limits.rate / (0.45 * samples), corners)
        pieces.append(_smooth(run, limits, samples))
    return np.concatenate(pieces)


def quick_ramps(limits: Limits, n: int) -> Array:
    """Return triangles of velocity, at nine tenths of the permitted acceleration."""
    a, top = 0.9 * limits.acceleration, limits.reachable
    period = max(QUICK, 4 * (top / a + 2 * a / limits.jerk))
    count = max(1, math.floor(n / limits.rate / period))
    pieces = []
    for samples in _shares(n, count):
        quarter = samples / limits.rate / 4
        corners = ([0, 0.25, 0.75, 1], [0, 1, -1, 0])
        triangle = partial(_polygon, limits, min(top, a * quarter), corners)
        pieces.append(_smooth(triangle, limits, samples))
    return np.concatenate(pieces)


def sweep(limits: Limits, n: int) -> Array:
    """Return a sine of rising frequency, see ``_sweep``, with a limited jerk."""
    return _smooth(partial(_sweep, limits), limits, n)


def _sweep(limits: Limits, n: int) -> Array:
    """Return a sine of rising frequency, its amplitude from three quarters of the speed to all."""
    stroke, a = limits.room, 0.9 * limits.acceleration
    top = min(limits.speed, math.sqrt(a * stroke) / 2)
    first = max(limits.frequency[0], 0.75 * top / (math.pi * stroke))
    fastest = min(a / top, math.sqrt(limits.jerk / top)) / (2 * math.pi)
    last = max(first, min(limits.frequency[1], fastest, limits.rate / 20))
    duration = n / limits.rate
    cycles = max(1, math.floor(0.5 * (first + last) * duration))  # whole ones, to end at 0
    last = max(first, 2 * cycles / duration - first)
    share = np.arange(n) / n
    phase = first * duration * share + (cycles - first * duration) * share**2
    values = top * (0.75 + 0.25 * share) * np.sin(2 * math.pi * phase)
    return bounded(_closed(values), limits)


def approach(limits: Limits, distance: float) -> Array:
    """Return a smooth move over a distance [m]: 1 - cos, as fast as the limits permit."""
    d, tau = abs(distance), 2 * math.pi
    duration = max(
        2 * d / limits.speed,
        (tau * d / limits.acceleration) ** 0.5,
        (tau**2 * d / limits.jerk) ** (1 / 3),
    )
    n = 1 + math.ceil(1.01 * duration * limits.rate)
    return np.asarray(distance * limits.rate / n * (1 - np.cos(tau * np.arange(n) / n)))


def _smooth(piece: Callable[[int], Array], limits: Limits, n: int) -> Array:
    """Return a piece (n,) whose jerk is limited by a moving average.

    The mean over w samples of an acceleration up to a has a jerk up to 2 a / w per sample. Speed,
    acceleration and range do not grow.
    """
    v = piece(n)
    if 2 * _jerk(v, limits) <= limits.jerk:  # beside the end of another piece
        return v
    a = np.abs(np.diff(v, append=0.0)).max() * limits.rate
    width = max(1, min(math.ceil(2 * a / limits.jerk * limits.rate), n // 4))
    v = np.convolve(piece(n - width), np.full(width, 1 / width))
    v = np.append(v, 0.0)
    return np.asarray(v * min(1.0, limits.jerk / _jerk(v, limits)))


def _jerk(v: Array, limits: Limits) -> float:
    return float(np.abs(np.diff(v, 2, prepend=[0.0], append=[0.0, 0.0])).max()) * limits.rate**2


def bounded(v: Array, limits: Limits) -> Array:
    """Return a velocity made so much smaller that it keeps the limits."""
    x = np.cumsum(v) / limits.rate
    slope = np.abs(np.diff(v, append=0.0)).max() * limits.rate
    most = np.array([np.abs(v).max(), slope, np.ptp(x)])
    allowed = np.array([limits.speed, limits.acceleration, 0.95 * limits.room])
    with np.errstate(divide="ignore"):
        return v * np.float64(min(1.0, np.min(allowed / most)))


def _out_and_back(limits: Limits, size: float, samples: int) -> Array:
    """Return one sine of velocity that leads a distance [m] away, and back."""
    v = math.pi * size * limits.rate / samples
    return bounded(v * np.sin(2 * math.pi * np.arange(samples) / samples), limits)


def _polygon(
    limits: Limits, v: float, corners: tuple[Sequence[float], Sequence[float]], samples: int
) -> Array:
    """Return straight lines between corners: shares of the time, and of a speed."""
    return bounded(v * np.interp(np.arange(samples) / samples, *corners), limits)


def _closed(v: Array) -> Array:
    """Return a velocity that leads back: what is missing is spread over the whole."""
    window = np.sin(math.pi * np.arange(len(v)) / len(v)) ** 2
    return np.asarray(v - window * (v.sum() / window.sum()))


def _shares(n: int, count: int) -> list[int]:
    """Split n samples into ``count`` nearly equal shares."""
    edges = np.linspace(0, n, count + 1).round().astype(int)
    return [int(share) for share in np.diff(edges)]
