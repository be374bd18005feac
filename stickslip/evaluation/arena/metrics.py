"""What is measured on a run of an entrant, from the true motion of the drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stickslip.evaluation.arena.commands import Command
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop

ERROR = "error"
"""The metric by which entrants are ranked."""
RECORDED = ("drive.v", "drive.x", "controller.u", "nominal.v_r")
Figures = dict[str, tuple[float, str]]
"""Value and unit by name of the metric."""


@dataclass(frozen=True)
class Trace:
    """One run.

    Attributes
    ----------
    v_cmd : (n,) command [m/s]
    v, x : (n,) true velocity [m/s] and position since the start [m]
    u : (n,) force command [N]
    v_r : (n,) velocity of the loop without friction [m/s]
    """

    v_cmd: Array
    v: Array
    x: Array
    u: Array
    v_r: Array

    @classmethod
    def of(cls, v_cmd: Array, recorded: Mapping[str, Array]) -> Trace:
        """Return it from the recorded signals."""
        v, x, u, v_r = (np.asarray(recorded[name][: len(v_cmd)]) for name in RECORDED)
        return cls(v_cmd, v, x - x[0], u, v_r)


def figures(command: Command, trace: Trace, loop: VelocityLoop) -> Figures:
    """Return all metrics of a run.

    ``effort`` is by how much the RMS of the force command is above that of the motion without
    friction; ``variation`` is the mean absolute rate at which the command changes.
    """
    T_s, gap = loop.T_s, trace.v - trace.v_cmd
    x_cmd = np.concatenate([[0.0], np.cumsum(trace.v_cmd[:-1])]) * T_s
    inert = loop.axis.m * np.gradient(trace.v_r, T_s) + loop.axis.b * trace.v_r
    found: Figures = {}
    squares = []
    for name, spans in command.motion.regions.items():
        inside = np.concatenate([gap[_samples(span, T_s)] for span in spans])
        scale, unit = command.relative.get(name, 1.0), command.unit
        found[f"E_rms {name}"] = (_rms(inside) / scale, unit)
        found[f"E_max {name}"] = (float(np.abs(inside).max()) / scale, unit)
        if name in command.counted:
            squares.append(np.mean(inside**2) / scale**2)
    found = {ERROR: (float(np.sqrt(np.mean(squares))), command.unit), **found}
    found["E_rms"] = (_rms(gap), "m/s")
    found["position RMS"] = (_rms(trace.x - x_cmd), "m")
    found["variation"] = (float(np.abs(np.diff(trace.u)).mean()) / T_s, "N/s")
    found["effort"] = (_rms(trace.u) - _rms(inert), "N")
    found["largest force"] = (float(np.abs(trace.u).max()), "N")
    return found


def _samples(span: tuple[float, float], T_s: float) -> slice:
    begin, end = span
    return slice(round(begin / T_s), round(end / T_s) + 1)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
