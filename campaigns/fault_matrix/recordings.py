"""Experiments with a drive, sound ones and those that are at fault themselves."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

import stickslip as ss
from campaigns.fault_matrix.drives import Drive
from stickslip import cosim
from stickslip.logs import Column, Description
from stickslip.planning import plan
from stickslip.servo.systems import servo_loop
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.studies.learn.recorded import gains_of

MEASURED = {"position": "drive.x_enc", "force": "drive.F_m", "force_command": "controller.u"}
MOVES = 1.1
"""Smallest limit of the force, in static friction: the drive breaks away."""


@dataclass(frozen=True)
class Experiment:
    """How a drive is recorded.

    Attributes
    ----------
    one_way : the drive never reverses
    drift : share of friction that is lost from the begin to the end
    limit : quantile of the force of the sound experiment at which the drive saturates; 1: none
    K_x : gain of a position loop around the velocity loop [1/s]
    inertia : share of the mass in a feedforward of inertia
    """

    one_way: bool = False
    drift: float = 0.0
    limit: float = 1.0
    K_x: float = 0.0
    inertia: float = 0.0


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
    scenario = _drift(drive, experiment.drift, table["time"]) if experiment.drift else None
    log = _run(fmus, loop, table, parameters, scenario)
    columns = {name: Column(name) for name in log}
    return log, Description(columns=columns, controller="PI", gains=gains_of(loop))


def _run(
    fmus: Path,
    loop: VelocityLoop,
    table: pd.DataFrame,
    parameters: dict[str, float | bool],
    scenario: cosim.Scenario | None,
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
        result = simulation.run(parameters, inputs, scenario=scenario)
    measured = {name: result[variable] for name, variable in MEASURED.items()}
    measured["force_command"] = np.append(measured["force_command"][1:], 0.0)  # of that sample
    return table.assign(**measured)


def _drift(drive: Drive, drift: float, time: pd.Series) -> cosim.Scenario:
    """Return friction that falls in steps of 1 %."""
    t, start = time.to_numpy(), drive.start
    scenario = ss.Scenario()
    for lost in np.arange(0.01, drift + 0.005, 0.01):
        at = float(t[round(lost / drift * 0.95 * (len(t) - 1))])
        for name in ("F_c", "F_s"):
            if name in start:
                scenario = scenario.set(f"drive.{name}", (1.0 - lost) * float(start[name]), at)
    return scenario
