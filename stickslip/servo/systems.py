"""The paper's loops as systems of FMUs: Fig. 2a around a drive, and what experiments need of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from stickslip import cosim, models
from stickslip.servo.velocity_loop import VelocityLoop

Feed = Literal["nominal", "command"]
NOMINAL_ORDER = 8
"""States that the nominal-loop FMU has room for."""
FEEDS: tuple[Feed, ...] = ("nominal", "command")


def build_fmus(folder: Path, truth: Mapping[str, float]) -> None:
    """Build the FMUs of the loop into a folder; ``truth`` goes into the drive as start values."""
    for name in models.model_names():
        models.build_fmu(name, folder, start=truth if name == "drive" else None)


def servo_loop(fmus: Path, loop: VelocityLoop) -> cosim.System:
    """Return controller and drive alone, with the inputs of ``loop.commands``."""
    system = cosim.System("servo")
    _add_servo(system, fmus, loop)
    _expose(system, loop, ["controller"])
    return system


def feedforward(
    fmus: Path, loop: VelocityLoop, compensator: Mapping[str, float], feed: Feed = "nominal"
) -> cosim.System:
    """Return nominal loop and compensator without a drive, with the inputs of ``loop.commands``.

    Parameters
    ----------
    fmus : folder of the FMUs
    loop : gives the nominal loop its matrices
    compensator : its parameters by name
    feed : what drives the compensator, the nominal loop's response or the command
    """
    system = cosim.System("feedforward")
    _add_feedforward(system, fmus, loop, compensator, feed)
    _expose(system, loop, ["nominal"], feed)
    return system


def paper_loop(
    fmus: Path,
    loop: VelocityLoop,
    compensator: Mapping[str, float] | None,
    feed: Feed = "nominal",
) -> cosim.System:
    """Return Fig. 2a: servo loop, compensator, nominal loop, with the inputs of ``loop.commands``.

    Parameters are those of ``feedforward``; a compensator of None runs beside the loop only. A
    velocity filter takes the compensator's force for known friction.
    """
    system = cosim.System("loop")
    _add_feedforward(system, fmus, loop, compensator or {}, feed)
    _add_servo(system, fmus, loop)
    _expose(system, loop, ["controller", "nominal"], feed)
    if compensator is not None:
        system.connect("compensator.F_mean", "controller.F_ff")
        if loop.velocity_filter is not None:
            system.connect("compensator.F_mean", "filter.F_ff")
    return system


def _add_feedforward(
    system: cosim.System,
    fmus: Path,
    loop: VelocityLoop,
    compensator: Mapping[str, float],
    feed: Feed,
) -> None:
    system.add("nominal", fmus / "nominal_loop.fmu", nominal_parameters(loop))
    timing = {"hold": False, "lead": loop.axis.tau_i}
    system.add("compensator", fmus / "compensator.fmu", {**timing, **compensator})
    if feed == "nominal":
        system.connect("nominal.v_r", "compensator.v")


def _expose(
    system: cosim.System, loop: VelocityLoop, commanded: list[str], feed: Feed = "nominal"
) -> None:
    """Expose what ``loop.commands`` gives to the components that take it."""
    fed = ["compensator.v"] if feed == "command" else []
    system.expose("v_cmd", *(f"{name}.v_cmd" for name in commanded), *fed)
    if loop.m_ff:
        system.expose("a_cmd", *(f"{name}.a_cmd" for name in commanded))


def nominal_parameters(loop: VelocityLoop) -> dict[str, float]:
    """Return the parameters of the nominal-loop FMU: the matrices of ``nominal``, ``acceleration``.

    What the order of the loop leaves unused is 0, whatever the FMU starts with.
    """
    nominal = loop.nominal
    matrices = {
        "A": nominal.A,
        "B": nominal.B[:, 0],
        "E": loop.acceleration.B[:, 0],
        "C": nominal.C[0],
    }
    values = {"T_s": loop.T_s, "D": float(nominal.D[0, 0])}
    for name, matrix in matrices.items():
        room = np.zeros((NOMINAL_ORDER,) * matrix.ndim)
        room[tuple(slice(n) for n in matrix.shape)] = matrix
        for index, value in np.ndenumerate(room):
            values[f"{name}[{','.join(str(i + 1) for i in index)}]"] = float(value)
    return values


def _add_servo(system: cosim.System, fmus: Path, loop: VelocityLoop) -> None:
    gains = {"T_s": loop.T_s, "K_p": loop.K_p, "K_i": loop.K_i, "tau_f": loop.tau_f}
    gains["m_ff"] = loop.m_ff
    filtered = loop.velocity_filter
    if filtered is not None:
        system.add("filter", fmus / "velocity_filter.fmu", filtered.parameters())
    system.add(
        "controller",
        fmus / "velocity_controller.fmu",
        {**gains, "use_v_hat": filtered is not None},
    )
    system.add("drive", fmus / "drive.fmu")
    system.connect("controller.u", "drive.u")
    system.connect("drive.x_enc", "controller.x_enc")
    if filtered is not None:
        system.connect("drive.x_enc", "filter.x_enc")
        system.connect("drive.F_m", "filter.F_m")
        system.connect("filter.v_hat", "controller.v_hat")
