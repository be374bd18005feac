"""A loop with known friction, run with and without a compensator, and what a guard finds there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.catalog.parameters import friction_law
from stickslip.models import Law
from stickslip.servo.axis import Datasheet
from stickslip.servo.measurement import Array, require_bounded
from stickslip.servo.systems import Feed, paper_loop
from stickslip.servo.velocity_loop import VelocityLoop


@dataclass(frozen=True)
class Trial:
    """What is tried; the axis is a drive FMU with the mass and lag that the loop counts on."""

    fmus: Path  # folder of the FMUs, as ``build_fmus`` leaves it
    loop: VelocityLoop  # the velocity loop
    friction: Mapping[str, float]  # of the axis, parameters of ``law`` by name
    compensator: Mapping[str, float]  # its parameters by name
    v_cmd: Array  # command (n,) [m/s], one value a sample of the loop
    feed: Feed = "nominal"
    datasheet: Datasheet = field(default_factory=Datasheet)
    law: Law = field(default_factory=friction_law)  # friction law of axis and compensator

    @contextmanager
    def runs(self, *, compensated: bool) -> Iterator[Run]:
        """Prepare runs with or without the compensator."""
        chosen = dict(self.compensator) if compensated else None
        system = paper_loop(self.fmus, self.loop, chosen, self.feed)
        axis = {**self.friction, **axis_values(self.loop, self.datasheet)}
        system.parameters |= in_loop(axis)
        stop = (len(self.v_cmd) - 1) * self.loop.T_s
        with system.prepare(step=self.loop.T_s, stop=stop, record=("drive.v",)) as simulation:
            yield Run(self, simulation)


def axis_values(loop: VelocityLoop, sheet: Datasheet) -> dict[str, float | bool]:
    """Return the start values of a drive FMU on the axis that a loop counts on."""
    known = {**loop.axis.of_drive(), "u_max": sheet.peak_force}
    # The paper's converter has steps larger than the friction of a small drive.
    return {**known, "dac": False, "encoder_step": sheet.encoder_step}


def in_loop(drive: Mapping[str, float]) -> dict[str, float]:
    """Return start values of a drive FMU as those of a loop, whose controller has its limit."""
    values = {f"drive.{name}": value for name, value in drive.items()}
    return {**values, "controller.u_max": drive["u_max"]}


@dataclass(frozen=True)
class Run:
    """A prepared loop."""

    trial: Trial
    simulation: cosim.Simulation

    def velocity(self, compensator: Mapping[str, float] | None = None) -> Array:
        """Return the velocity (n,) [m/s], with other parameters of the compensator than its own."""
        values = {f"compensator.{name}": value for name, value in (compensator or {}).items()}
        commands = self.trial.loop.commands(self.trial.v_cmd)
        return self.simulation.run(values, commands)["drive.v"]

    def error(self, compensator: Mapping[str, float] | None = None) -> float:
        """Return the RMS of v - v_cmd [m/s]; infinite when the run fails or the loop runs away.

        In a cascade, which may lag behind its command, it is that to the motion without friction.
        """
        loop, target = self.trial.loop, self.trial.v_cmd
        if loop.K_x:
            target, _ = loop.response(target)
        try:
            v = self.velocity(compensator)
            require_bounded(v, float(np.max(np.abs(self.trial.v_cmd))))
        except cosim.SimulationError:
            return np.inf
        return float(np.sqrt(np.mean((v - target) ** 2)))


@dataclass(frozen=True)
class Finding:
    """One warning."""

    guard: str  # name of the guard
    # what was found and the largest acceptable value, in ``unit``
    figure: float
    limit: float
    unit: str
    message: str  # what, figure, limit and what to do, in a line

    def __str__(self) -> str:
        return f"{self.guard}: {self.message}"
