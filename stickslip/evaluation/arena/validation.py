"""How well a tuned entrant does on commands on which it was not tuned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stickslip import cosim
from stickslip.evaluation.arena.commands import Command
from stickslip.evaluation.arena.course import Course
from stickslip.evaluation.arena.entrants import Entrant, Tuned
from stickslip.evaluation.arena.metrics import RECORDED, Trace, figures
from stickslip.servo.chain_response import ChainResponse
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop

POINTS = 240
"""Intervals of a time plot, each with its least and its greatest value."""


@dataclass
class Validated:
    """What an entrant did, as plain data.

    Attributes
    ----------
    figures : (command, metric, unit) -> a value for each start
    plots : command -> least and greatest velocity error [um/s] in each interval of the first run
    reason : why a run failed; its errors are infinite
    """

    figures: dict[tuple[str, str, str], list[float]] = field(default_factory=dict)
    plots: dict[str, list[int]] = field(default_factory=dict)
    reason: str = ""

    def document(self) -> dict[str, Any]:
        """Return it as JSON takes it."""
        rows = [[*key, values] for key, values in self.figures.items()]
        return {"values": rows, "plots": self.plots, "reason": self.reason}


def validate(
    fmus: Path,
    loop: VelocityLoop,
    one: Entrant,
    tuned: Tuned,
    commands: Sequence[Command],
    starts: int,
) -> Validated:
    """Run every command from several starts: other noise, other places between encoder steps."""
    sampled = {command.name: command.sample(loop.T_s) for command in commands}
    n = max(len(v_cmd) for v_cmd in sampled.values())
    found = Validated()
    with Course(fmus, loop, one, n, RECORDED) as course:
        for command in commands:
            v_cmd = sampled[command.name]
            for k in range(starts):
                place = ((k + 0.5) / starts - 0.5) * Datasheet().encoder_step
                try:
                    run = course.run(tuned, v_cmd, {"seed": k + 1, "x": place})
                except cosim.SimulationError as error:
                    found.reason = found.reason or str(error)
                    continue
                trace = Trace.of(v_cmd, {name: run[name] for name in RECORDED})
                for metric, (value, unit) in figures(command, trace, tuned.loop).items():
                    found.figures.setdefault((command.name, metric, unit), []).append(value)
                if k == 0:
                    found.plots[command.name] = _thinned(1e6 * (trace.v - v_cmd))
    return found


def sensitivities(
    fmus: Path, loop: VelocityLoop, one: Entrant, tuned: Tuned, friction: float, mass: float
) -> dict[str, float]:
    """Return the peak sensitivity on the axis of the design, and with the true mass [kg]."""
    with ChainResponse(fmus, loop, one.chain) as response:
        known = response.of(tuned.loop, tuned.parameters, friction)
        true = response.of(tuned.loop, tuned.parameters, friction, mass)
    return {"Ms": known.peak, "Ms with the true mass": true.peak}


def _thinned(values: Array) -> list[int]:
    """Return least and greatest value of each of ``POINTS`` intervals, one after the other."""
    parts = np.array_split(values, POINTS)
    ends = [end for part in parts for end in (part.min(), part.max())]
    return [round(float(end)) if math.isfinite(end) else 0 for end in ends]
