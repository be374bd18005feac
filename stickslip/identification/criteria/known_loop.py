"""The loop with a known controller: controller FMU, drive FMU, and the recorded commands.

The drive FMU represents the candidate: each estimated parameter is set, and its converter and
encoder are off unless the recording is simulated again with them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.catalog.space import Values
from stickslip.identification.controller.initial_state import fmu_gains, is_running, memory_force
from stickslip.identification.criteria.closing import Closing
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.criteria.runs import Runs
from stickslip.logs import Recording
from stickslip.servo.divergence import require_bounded
from stickslip.servo.measurement import Array

SHORTEST_LAG = 1e-7  # that the drive FMU takes [s]
NO_LIMIT = 1e9  # [N]
FEW = 11  # samples from which the first velocity is estimated
STATES: dict[str, Callable[[float, Values], float]] = {
    "z": lambda force, values: force / values["sigma_0"],
    "F_d": lambda force, _: force,
}
"""State of a friction law -> its value at rest under a force [N]. Other states start at 0."""


class KnownLoop(Closing):
    """Simulates the experiment of a recording."""

    def __init__(
        self,
        fmus: Path,  # folder of the FMUs
        recording: Recording,  # gives commands, start and encoder
        # parameters of the controller FMU by name, and its initial state, if it was running
        gains: Mapping[str, float],
        *,
        # whether the position is quantised; the trajectory is then not a smooth function of the
        # parameters
        encoder: bool = False,
        workers: int = 1,  # number of parallel runs
    ) -> None:
        position = position_of(recording)
        start = {"x": position[0], "v": _first_velocity(position, recording.T_s)}
        limits = {"u_max": NO_LIMIT, "T_s": recording.T_s}
        system = cosim.System("known_loop")
        system.add("controller", fmus / "velocity_controller.fmu", {**limits, **fmu_gains(gains)})
        step = recording.encoder_step
        optics: dict[str, object] = {"encoder": False}
        if encoder:
            optics = {"encoder": step > 0.0, "noise": True, "noise_F": 0.0}
            if step > 0.0:
                optics["encoder_step"] = step
        system.add(
            "candidate", fmus / "drive.fmu", {"dac": False, "u_max": NO_LIMIT, **optics, **start}
        )
        system.connect("controller.u", "candidate.u")
        system.connect("candidate.x_enc", "controller.x_enc")
        self._inputs = {"F_ff": np.zeros_like(recording.t), **recording.controller_inputs}
        self._speed = _top_speed(recording)
        for name in self._inputs:
            system.expose(name, f"controller.{name}")
        specification = cosim.Specification(
            system,
            step=recording.T_s,
            stop=(len(recording.t) - 1) * recording.T_s,
            record=(
                "candidate.x",
                "candidate.v",
                "candidate.x_enc",
                "candidate.F_m",
                "controller.u",
            ),
        )
        self._runs = Runs(specification, workers)
        self.each, self.workers = self._runs.each, workers
        self._memory = memory_force(gains, len(recording.t), recording.T_s)
        force = recording.force if is_running(gains) else None
        self._first = None if force is None else float(force[0])
        self._states = cosim.Fmu(fmus / "drive.fmu").variables.keys()

    def run(
        self,
        values: Values,
        # parameters of this run only, such as ``candidate.noise_x``
        further: Mapping[str, float] | None = None,
        feedforward: Array | float = 0.0,  # (n,) force of a compensator from each sample on [N]
    ) -> cosim.Result:
        """Run the experiment with these values in the drive."""
        parameters = {**candidate(values), **(further or {})}
        if self._first is not None:  # friction balances the motor force
            held = float(np.clip(self._first - values["F_0"], -values["F_c"], values["F_c"]))
            for name, state in STATES.items():
                if name in self._states:
                    parameters[f"candidate.{name}"] = state(held, values)
        F_ff = self._inputs["F_ff"] + self._memory - values["F_0"] + feedforward
        return self._runs.run(parameters, {**self._inputs, "F_ff": F_ff})

    def bounded(
        self,
        values: Values,
        further: Mapping[str, float] | None = None,
        feedforward: Array | float = 0.0,
    ) -> cosim.Result:
        """Do what ``run`` does, for figures that are shown.

        Raises Diverged when the drive runs away from its command.
        """
        result = self.run(values, further, feedforward)
        require_bounded(result["candidate.v"], self._speed)
        return result

    def close(self) -> None:
        """Free the FMUs."""
        self._runs.close()


def _top_speed(recording: Recording) -> float:
    """Return the largest speed of the commands and of the motion [m/s]."""
    places = (position_of(recording), recording.position_command)
    rates = [np.diff(place) / recording.T_s for place in places if place is not None]
    if "v_cmd" in recording.controller_inputs:
        rates.append(recording.controller_inputs["v_cmd"])
    return max(float(np.max(np.abs(rate))) for rate in rates)


def candidate(values: Values) -> dict[str, float]:
    """Return the drive FMU's parameters for values by name."""
    elsewhere = ("F_0", "delay")
    parameters = {f"candidate.{n}": value for n, value in values.items() if n not in elsewhere}
    parameters["candidate.b"] = max(values["b"], 0.0)
    parameters["candidate.tau_i"] = max(values["delay"], SHORTEST_LAG)
    return parameters


def _first_velocity(position: Array, T_s: float) -> float:
    """Return the slope of a parabola at its begin [m/s]."""
    few = position[:FEW]
    return float(np.polyfit(np.arange(len(few)) * T_s, few, 2)[1])
