"""What a drive may be asked to do."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from numbers import Real

from stickslip.errors import UsageError
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
    slow : speeds of the slow reversals, smallest and largest [m/s]
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
    slow: tuple[float, float] = (1e-4, 5e-3)
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

ROTARY = Limits(
    stroke=2 * math.pi,
    speed=2 * math.pi,
    acceleration=200.0,
    slow=(0.01, 0.5),
    presliding=(1e-4, 0.1),
)
"""A motor shaft and one turn."""
