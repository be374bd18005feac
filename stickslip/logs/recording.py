"""One log of a drive, on an even grid, in SI units, and findings of its checks."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from stickslip.errors import with_settings
from stickslip.servo.measurement import Array

Motion = Literal["linear", "rotary"]


@dataclass(frozen=True)
class Segment:
    """One of the logs that a recording joins, or of the stretches of one."""

    begin: int  # its first sample
    end: int  # the sample behind its last one
    source: str  # where it comes from, as displayed
    # of its controller's FMU; None where not known
    gains: Mapping[str, float] | None = field(default=None, compare=False)
    load: float = 0.0  # mass that it moves beside that of the drive [kg]
    log: int = 0  # number of the log; stretches of one have the same


@dataclass(frozen=True)
class Recording:
    """What a drive showed; a signal that was not logged is None.

    For a rotary drive read rad for m, N m for N and kg m^2 for kg throughout.
    """

    t: Array  # (n,) even, from 0 on [s]
    position: Array | None = None  # (n,) shown by the encoder [m]
    force: Array | None = None  # (n,) of the motor, at each sample [N]
    velocity: Array | None = None  # (n,) logged beside or instead of the position [m/s]
    friction: Array | None = None  # (n,) measured friction force [N], as a tribometer shows it
    position_command: Array | None = None  # (n,) [m]
    velocity_command: Array | None = None  # (n,) [m/s]
    force_command: Array | None = None  # (n,) [N]
    added_force: Array | None = None  # (n,) added to the controller's output, as pulses [N]
    # (n,) that was added to the velocity command, such as dither [m/s]
    added_velocity: Array | None = None
    # (n,) of the motor's force, what neither mass nor friction takes: gravity, cogging [N]
    known_force: Array | None = None
    # (n,) by what the weight that the drive holds multiplies its friction [1]
    friction_factor: Array | None = None
    encoder_step: float = 0.0  # resolution of the position [m]; 0 when none shows
    motion: Motion = "linear"  # linear or rotary
    source: str = "recording"  # where it comes from, as displayed
    segments: tuple[Segment, ...] = ()  # the logs that it joins; none where it is a single one

    @property
    def arrays(self) -> dict[str, Array]:
        """Its signals and their times (n,) by name."""
        return {name: one for name, one in vars(self).items() if isinstance(one, np.ndarray)}

    def part(self, begin: int, end: int) -> "Recording":
        """Return its samples from one on to another, whose time begins at 0."""
        cut: dict[str, Any] = {name: one[begin:end].copy() for name, one in self.arrays.items()}
        return replace(self, **cut | {"t": self.t[: end - begin].copy(), "segments": ()})

    @property
    def pieces(self) -> tuple[Segment, ...]:
        """The logs that it joins, or itself as the only one."""
        return self.segments or (Segment(0, len(self.t), self.source),)

    def log(self, segment: Segment) -> "Recording":
        """Return one of the logs that it joins; a single one is returned as it is."""
        if not self.segments:
            return self
        return replace(self.part(segment.begin, segment.end), source=segment.source)

    @property
    def first(self) -> "Recording":
        """The first of the logs that it joins; of its stretches that in which it moves farthest."""

        def way(log: Recording) -> float:
            shown = log.velocity if log.position is None else np.diff(log.position)
            return 0.0 if shown is None else float(np.sum(np.abs(shown)))

        own = [one for one in self.pieces if one.log == self.pieces[0].log]
        return max(map(self.log, own), key=way)

    @property
    def joins_several(self) -> bool:
        """Whether it is of several logs, and not only of stretches of one."""
        return len({one.log for one in self.pieces}) > 1

    @property
    def rotary(self) -> bool:
        """Whether the drive is rotary."""
        return self.motion == "rotary"

    def moving(self, force: Array) -> Array:
        """Return what of a force (n,) of the motor [N] moves the mass against friction."""
        return force if self.known_force is None else force - self.known_force

    @property
    def controller_inputs(self) -> dict[str, Array]:
        """What the controller received (n,), by inputs of its FMU: v_cmd, x_cmd and F_ff."""
        v_cmd, added = self.velocity_command, self.added_velocity
        if v_cmd is not None and added is not None:
            added = v_cmd + added
        inputs = {
            "v_cmd": v_cmd if added is None else added,
            "x_cmd": self.position_command,
            "F_ff": self.added_force,
        }
        return {name: signal for name, signal in inputs.items() if signal is not None}

    @property
    def T_s(self) -> float:  # noqa: N802 - the symbol of the paper
        """Sample period [s]."""
        return float(self.t[-1] / (len(self.t) - 1))


Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One finding of a check of a recording; as text it is one line."""

    severity: Severity  # error (nothing can be learned), warning (something will suffer), note
    what: str  # was found
    figure: str = ""  # the number behind it, with its unit
    advice: str = ""  # what to do; empty when nothing need be done
    # "intervals" where the learned intervals are too narrow, "values" where the learned values are
    # wrong
    spoils: Literal["", "intervals", "values"] = ""
    hides: tuple[str, ...] = ()  # parameters that cannot be identified therefore
    log: str = ""  # of several, the one that the others contradict

    @classmethod
    def either(cls, fine: bool, words: tuple[str, str], figure: str, advice: str) -> "Finding":
        """Return a note without advice, or a warning."""
        note, warning = words
        return cls("note", note, figure) if fine else cls("warning", warning, figure, advice)

    def __post_init__(self) -> None:
        for name in ("what", "advice"):
            object.__setattr__(self, name, with_settings(getattr(self, name)))

    def __str__(self) -> str:
        figure = f": {self.figure}" if self.figure else ""
        advice = f"; {self.advice}" if self.advice else ""
        return f"{self.severity}: {self.what}{figure}{advice}"
