"""The paper's loops as systems of FMUs: Fig. 2a around a drive, and what experiments need of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np

import cosim
import models
from cosim.control import VelocityLoop

Feed = Literal["nominal", "command"]
NOMINAL_ORDER = 8
"""States that the nominal-loop FMU has room for."""
FEEDS: tuple[Feed, ...] = ("nominal", "command")


def build_fmus(folder: Path, truth: Mapping[str, float]) -> None:
    """Build the FMUs of the loop into a folder; ``truth`` goes into the drive as start values."""
    for name in models.model_names():
        models.build_fmu(name, folder, start=truth if name == "drive" else None)


def servo_loop(fmus: Path, loop: VelocityLoop) -> cosim.System:
    """Return controller and drive alone, with input ``v_cmd`` [m/s]."""
    system = cosim.System("servo")
    _add_servo(system, fmus, loop)
    system.expose("v_cmd", "controller.v_cmd")
    return system


def feedforward(
    fmus: Path, loop: VelocityLoop, compensator: Mapping[str, float], feed: Feed = "nominal"
) -> cosim.System:
    """Return nominal loop and compensator without a drive, with input ``v_cmd`` [m/s].

    Parameters
    ----------
    fmus : folder of the FMUs
    loop : gives the nominal loop its matrices
    compensator : its parameters by name
    feed : what drives the compensator, the nominal loop's response or the command
    """
    system = cosim.System("feedforward")
    commanded = _add_feedforward(system, fmus, loop, compensator, feed)
    system.expose("v_cmd", *commanded)
    return system


def paper_loop(
    fmus: Path,
    loop: VelocityLoop,
    compensator: Mapping[str, float] | None,
    feed: Feed = "nominal",
) -> cosim.System:
    """Return Fig. 2a: servo loop, compensator and nominal loop, with input ``v_cmd`` [m/s].

    Parameters are those of ``feedforward``; a compensator of None runs beside the loop only.
    """
    system = cosim.System("loop")
    commanded = _add_feedforward(system, fmus, loop, compensator or {}, feed)
    _add_servo(system, fmus, loop)
    system.expose("v_cmd", "controller.v_cmd", *commanded)
    if compensator is not None:
        system.connect("compensator.F_mean", "controller.F_ff")
    return system


def _add_feedforward(
    system: cosim.System,
    fmus: Path,
    loop: VelocityLoop,
    compensator: Mapping[str, float],
    feed: Feed,
) -> list[str]:
    """Add nominal loop and compensator; return the inputs that the command feeds."""
    system.add("nominal", fmus / "nominal_loop.fmu", nominal_parameters(loop))
    timing = {"hold": False, "lead": loop.axis.tau_i}
    system.add("compensator", fmus / "compensator.fmu", {**timing, **compensator})
    if feed == "command":
        return ["nominal.v_cmd", "compensator.v"]
    system.connect("nominal.v_r", "compensator.v")
    return ["nominal.v_cmd"]


def nominal_parameters(loop: VelocityLoop) -> dict[str, float]:
    """Return the parameters of the nominal-loop FMU: the matrices of ``loop.nominal``.

    What the order of the loop leaves unused is 0, whatever the FMU starts with.
    """
    nominal = loop.nominal
    matrices = {"A": nominal.A, "B": nominal.B[:, 0], "C": nominal.C[0]}
    values = {"T_s": loop.T_s, "D": float(nominal.D[0, 0])}
    for name, matrix in matrices.items():
        room = np.zeros((NOMINAL_ORDER,) * matrix.ndim)
        room[tuple(slice(n) for n in matrix.shape)] = matrix
        for index, value in np.ndenumerate(room):
            values[f"{name}[{','.join(str(i + 1) for i in index)}]"] = float(value)
    return values


def _add_servo(system: cosim.System, fmus: Path, loop: VelocityLoop) -> None:
    gains = {"T_s": loop.T_s, "K_p": loop.K_p, "K_i": loop.K_i, "tau_f": loop.tau_f}
    system.add("controller", fmus / "velocity_controller.fmu", gains)
    system.add("drive", fmus / "drive.fmu")
    system.connect("controller.u", "drive.u")
    system.connect("drive.x_enc", "controller.x_enc")
