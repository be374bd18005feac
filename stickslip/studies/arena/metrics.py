"""What is measured on a run of an entrant, from the true motion of the drive."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stickslip import cosim
from stickslip.evaluation.motions import Span
from stickslip.servo.measurement import Array, measured_velocity, turns
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.studies.arena.motion_commands import Command

ERROR = "error"  # The metric by which entrants are ranked
RECORDED = ("drive.v", "drive.x", "controller.u", "nominal.v_r")
Figures = dict[str, tuple[float, str]]  # Value and unit by name of the metric

SETTLED, COUNTS = 1e-6, 2.0
"""A move has settled within this position error [m], or so many steps of the encoder."""


@dataclass(frozen=True)
class Trace:
    """One run."""

    T_s: float  # sample period [s]
    v_cmd: Array  # (n,) commanded velocity [m/s]
    # (n,) true velocity [m/s] and position [m]
    v: Array
    x: Array
    u: Array  # (n,) force command [N]
    v_r: Array  # (n,) velocity of the loop without friction [m/s]
    encoder_step: float  # resolution of the encoder [m]

    @classmethod
    def of(cls, T_s: float, v_cmd: Array, recorded: cosim.Result, encoder_step: float) -> "Trace":
        """Return it from the recorded signals."""
        v, x, u, v_r = (np.asarray(recorded[name][: len(v_cmd)]) for name in RECORDED)
        return cls(T_s, v_cmd, v, x, u, v_r, encoder_step)

    @classmethod
    def measured(cls, T_s: float, v_cmd: Array, x_enc: Array, encoder_step: float) -> "Trace":
        """Return what the encoder (n,) [m] shows of a run; forces are not known."""
        v, unknown = measured_velocity(x_enc, T_s), np.full(len(v_cmd), np.nan)
        return cls(T_s, v_cmd, v, x_enc, unknown, unknown, encoder_step)

    @property
    def x_cmd(self) -> Array:
        """Commanded position (n,) [m]."""
        return self.T_s * np.concatenate([[0.0], np.cumsum(self.v_cmd[:-1])])

    @property
    def velocity_error(self) -> Array:
        """Velocity less command (n,) [m/s]."""
        return self.v - self.v_cmd

    @property
    def position_error(self) -> Array:
        """Position less command (n,) [m]."""
        return self.x - self.x_cmd

    def within(self, values: Array, span: Span) -> Array:
        """Return the samples (k,) of a span of time."""
        begin, end = (round(edge / self.T_s) for edge in span)
        return values[begin:end]


def figures(command: Command, trace: Trace, loop: VelocityLoop) -> Figures:
    """Return all metrics of a run: those of its kind, and those of every run.

    ``effort`` is by how much the RMS of the force command is above that of the motion without
    friction; ``variation`` is the mean absolute rate at which the command changes.
    """
    inert = loop.axis.m * np.gradient(trace.v_r, trace.T_s) + loop.axis.b * trace.v_r
    return {
        **MEASURES[command.kind](command, trace),
        "E_rms": (_rms(trace.velocity_error), "m/s"),
        "position RMS": (_rms(trace.position_error), "m"),
        "variation": (float(np.abs(np.diff(trace.u)).mean()) / trace.T_s, "N/s"),
        "effort": (_rms(trace.u) - _rms(inert), "N"),
        "largest force": (float(np.abs(trace.u).max()), "N"),
    }


def _velocity(command: Command, trace: Trace) -> Figures:
    """Return RMS and largest error of the velocity in each region."""
    found: Figures = {}
    squares = []
    unit = "1" if command.relative else "m/s"
    for name, spans in command.motion.regions.items():
        inside = np.concatenate([trace.within(trace.velocity_error, span) for span in spans])
        inside = inside / command.relative.get(name, 1.0)
        found[f"E_rms {name}"] = (_rms(inside), unit)
        found[f"E_max {name}"] = (float(np.abs(inside).max()), unit)
        if name in command.counted:
            squares.append(np.mean(inside**2))
    return {ERROR: (float(np.sqrt(np.mean(squares))), unit), **found}


def _circle(command: Command, trace: Trace) -> Figures:
    """Return the heights of the quadrant glitches: largest change of the position error [m]."""
    found: Figures = {}
    every = []
    for name, spans in command.motion.regions.items():
        heights = []
        for begin, end in spans:
            before = trace.within(trace.position_error, (2.0 * begin - end, begin))
            after = trace.within(trace.position_error, (begin, end))
            heights.append(float(np.abs(after - np.median(before)).max()))
        found[f"quadrant glitch {name}"] = (max(heights), "m")
        every += heights
    return {ERROR: (_rms(np.array(every)), "m"), **found}


def _settling(command: Command, trace: Trace) -> Figures:
    """Return settling times [s], overshoots [1], and what is left at the end of the rest [m]."""
    found: Figures = {}
    every = []
    settled = max(SETTLED, COUNTS * trace.encoder_step)
    for name, spans in command.motion.regions.items():
        times, left, beyond = [], [], [0.0]
        there, back = (trace.within(trace.x_cmd, span)[0] for span in spans)
        for span, length in zip(spans, (there - back, back - there), strict=True):
            inside = trace.within(trace.position_error, span)
            outside = np.flatnonzero(np.abs(inside) > settled)
            beyond.append(float((inside / length).max()))
            times.append((outside[-1] + 1) * trace.T_s if len(outside) else 0.0)
            left.append(abs(float(inside[-len(inside) // 4 :].mean())))
            every.append(inside)
        found[f"settling {name}"] = (float(max(times)), "s")
        found[f"overshoot {name}"] = (max(beyond), "1")
        found[f"rest error {name}"] = (max(left), "m")
    return {ERROR: (_rms(np.concatenate(every)), "m"), **found}


def _hunting(command: Command, trace: Trace) -> Figures:
    """Return how far and how often the position swings at rest, and how the command changes.

    A reversal is a change of direction after a swing of more than ``COUNTS`` steps of the encoder.
    """
    ((span,),) = command.motion.regions.values()
    x, u = (trace.within(values, span) for values in (trace.x, trace.u))
    rate = float(np.abs(np.diff(u)).mean()) / trace.T_s
    left = float(np.abs(trace.within(trace.position_error, span).mean()))
    return {
        ERROR: (float(np.ptp(x)), "m"),
        "reversals at rest": (float(turns(x, COUNTS * trace.encoder_step)), "1"),
        "rest error": (left, "m"),
        "variation at rest": (rate, "N/s"),
    }


def _path(command: Command, trace: Trace) -> Figures:
    """Return RMS and largest position error [m]."""
    ((span,),) = command.motion.regions.values()
    inside = trace.within(trace.position_error, span)
    return {ERROR: (_rms(inside), "m"), "largest error": (float(np.abs(inside).max()), "m")}


MEASURES: dict[str, Callable[[Command, Trace], Figures]] = {
    "velocity": _velocity,
    "circle": _circle,
    "settling": _settling,
    "hunting": _hunting,
    "path": _path,
}
"""By the kind of the command."""


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
