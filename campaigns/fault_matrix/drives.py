"""Drives of every friction law, with what disturbs them, and experiments, sound and at fault."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd

import stickslip as ss
from stickslip.logs import Column, Description
from stickslip.planning import plan
from stickslip.rigs.contract import COMMISSIONING
from stickslip.servo.axis import Datasheet
from stickslip.servo.systems import servo_loop
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop
from stickslip.studies.learn.recorded import gains_of

LEVELS = ("F_c", "F_s")


@dataclass(frozen=True)
class Drive:
    """A drive by its friction law and the parameters of its FMU that are not Table 2's."""

    law: str = "lugre"
    parameters: dict[str, float | bool] = field(default_factory=dict)

    @property
    def start(self) -> dict[str, float]:
        """All its parameters by name."""
        model = ss.models.load_model("drive", self.law)
        return {variable.name: variable.start for variable in model.variables} | self.parameters

    @property
    def mass(self) -> float:
        """Moving mass [kg]."""
        return float(self.start["m"])

    @property
    def loop(self) -> VelocityLoop:
        """The loop in which it is recorded, and in which compensators are tried."""
        return design_velocity_loop(Datasheet().axis(self.mass, 0.0), COMMISSIONING)

    def at(self, level: float) -> dict[str, float]:
        """Return its levels of friction times a factor, for a run of its loop."""
        return {f"drive.{name}": level * self.start[name] for name in LEVELS if name in self.start}

    def friction(self, v: np.ndarray) -> np.ndarray:
        """Return friction at speeds v > 0 [N], the mean over directions and positions."""
        return steady(self.start, v)


def steady(values: dict[str, float], v: np.ndarray) -> np.ndarray:
    """Return friction at constant speeds v > 0 [N] by the parameters of any law."""
    force = values["F_c"] + values["b"] * v
    if "F_s" in values:
        rise = values["F_s"] - values["F_c"]
        force = force + rise * np.exp(-((v / values["v_s"]) ** values["delta"]))
    return force


DRIVES = {
    "Table 2": Drive(),
    "light": Drive(parameters={"m": 0.8, "F_c": 1.5, "F_s": 2.4, "v_s": 2e-3, "sigma_0": 1e5}),
    "heavy": Drive(parameters={"m": 14.0, "F_c": 14.0, "F_s": 20.0, "sigma_0": 8e5}),
    "flat": Drive(parameters={"F_s": 6.2, "F_c": 6.0, "v_s": 1e-3}),
    "dahl": Drive("dahl"),
    "gms": Drive("gms"),
    "coulomb_stribeck": Drive("coulomb_stribeck"),
    "along the guide": Drive(parameters={"position_dependent": True, "position_amplitude": 0.08}),
    "asymmetric": Drive(parameters={"asymmetric": True, "asymmetry": 0.08}),
    "coarse encoder": Drive(parameters={"encoder_step": 2e-6}),
    "slow current": Drive(parameters={"tau_i": 5e-4}),
    "ripple": Drive(parameters={"ripple": True, "ripple_amplitude": 0.3}),
}


MEASURED = {"position": "drive.x_enc", "force": "drive.F_m", "force_command": "controller.u"}
MOVES = 1.1
"""Smallest limit of the force, in static friction: the drive breaks away."""


@dataclass(frozen=True)
class Experiment:
    """How a drive is recorded."""

    one_way: bool = False  # the drive never reverses
    drift: float = 0.0  # share of friction that is lost from the begin to the end
    limit: float = 1.0  # quantile of the sound experiment's force at which it saturates; 1: none
    K_x: float = 0.0  # gain of a position loop around the velocity loop [1/s]
    inertia: float = 0.0  # share of the mass in a feedforward of inertia


SOUND = Experiment()


def record(
    fmus: Path, drive: Drive, experiment: Experiment, seed: int
) -> tuple[pd.DataFrame, Description]:
    """Return a log of the planned experiment, and the description of the sound one.

    The log's force is measured; ``force_command`` is that of the controller.
    """
    table = plan()
    if experiment.one_way:
        velocity = np.abs(table["velocity_command"])
        position = velocity.cumsum() * (table["time"][1] - table["time"][0])
        table = table.assign(velocity_command=velocity, position_command=position)
    loop = replace(drive.loop, m_ff=experiment.inertia * drive.mass)
    parameters: dict[str, float | bool] = {"drive.noise": True, "drive.seed": seed + 1}
    if experiment.K_x:
        parameters["controller.K_x"] = experiment.K_x
    if experiment.limit < 1.0:
        sound, _ = record(fmus, drive, replace(experiment, limit=1.0), seed)
        limit = float(np.quantile(np.abs(sound["force"]), experiment.limit))
        static = drive.start.get("F_s", drive.start["F_c"])
        parameters["drive.u_max"] = max(limit, MOVES * static)
    tunable = _drift(drive, experiment.drift, table["time"]) if experiment.drift else {}
    log = _run(fmus, loop, table, parameters, tunable)
    columns = {name: Column(name) for name in log}
    return log, Description(columns=columns, controller="PI", gains=gains_of(loop))


def _run(
    fmus: Path,
    loop: VelocityLoop,
    table: pd.DataFrame,
    parameters: dict[str, float | bool],
    tunable: dict[str, ss.Table],
) -> pd.DataFrame:
    v_cmd = table["velocity_command"].to_numpy()
    system, inputs = servo_loop(fmus, loop), {"v_cmd": v_cmd}
    if loop.m_ff:
        inputs["a_cmd"] = np.gradient(v_cmd, loop.T_s)
    if "controller.K_x" in parameters:
        system.expose("x_cmd", "controller.x_cmd")
        inputs["x_cmd"] = table["position_command"].to_numpy()
    stop = (len(v_cmd) - 1) * loop.T_s
    with system.prepare(step=loop.T_s, stop=stop, record=tuple(MEASURED.values())) as simulation:
        result = simulation.run(parameters, inputs, tunable=tunable)
    measured = {name: result[variable] for name, variable in MEASURED.items()}
    measured["force_command"] = np.append(measured["force_command"][1:], 0.0)  # of that sample
    return table.assign(**measured)


def _drift(drive: Drive, drift: float, time: pd.Series) -> dict[str, ss.Table]:
    """Return friction that falls in steps of 1 %."""
    t, lost = time.to_numpy(), np.arange(0.0, drift + 0.005, 0.01)
    at = t[np.round(lost / drift * 0.95 * (len(t) - 1)).astype(int)]
    return {
        f"drive.{name}": ss.Table(at, (1.0 - lost) * float(drive.start[name]), held=True)
        for name in ("F_c", "F_s")
        if name in drive.start
    }
