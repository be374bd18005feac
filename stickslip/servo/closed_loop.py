"""A velocity loop with compensators around a simulated drive, in one call."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from stickslip import cosim, models
from stickslip.errors import UsageError, number
from stickslip.servo.chain_response import ChainResponse, Robustness
from stickslip.servo.systems import Compensator, build_loop
from stickslip.servo.velocity_loop import VelocityLoop


def closed_loop(
    loop: VelocityLoop,
    compensators: Sequence[Compensator] = (),
    *,
    folder: Path | str = "fmus",
    law: str = "lugre",
    drive: Mapping[str, object] | None = None,
) -> cosim.System:
    """Build the FMUs of a velocity loop around a simulated drive, and connect them.

    The components are ``nominal``, the loop without friction, whose output ``v_r`` is the velocity
    to be reached; ``controller``, ``drive``, and the compensators by their names. The input
    ``v_cmd`` is the velocity command [m/s]; run it with ``step=loop.T_s``.

    Parameters
    ----------
    loop : controller gains and axis
    compensators : in the order in which their forces are added
    folder : for the FMUs
    law : friction law of the drive
    drive : start values of the drive by variable, such as ``F_c``; mass, viscous friction and lag
        of the motor are those of the loop's axis unless given here

    Raises
    ------
    UnknownLaw, UnknownModel
        When there is no such law or compensator.
    ParameterError
        When the drive has no such variable, or not for this value.
    ValueError
        When a model is no compensator, or cannot take the force of the one before it.
    """
    fmus = Path(folder) / law
    models.build_fmu("drive", fmus, law=law)
    chain = _built(fmus, ("nominal_loop", "velocity_controller"), compensators)
    system = build_loop(fmus, loop, chain)
    for name, value in {**loop.axis.of_drive(), **(drive or {})}.items():
        system.set(f"drive.{name}", value)
    return system


def robustness(
    loop: VelocityLoop,
    compensators: Sequence[Compensator],
    *,
    friction: float,
    folder: Path | str = "fmus",
    m: float | None = None,
) -> Robustness:
    """Return the peak sensitivity Ms of a loop with compensators, and how it passes noise on.

    The compensators are FMUs of which nothing is known: their response to an impulse at each input
    is measured in motion at constant velocity, and the loop is closed over it.

    Parameters
    ----------
    loop, compensators, folder : as of ``closed_loop``
    friction : force of sliding [N]
    m : true mass [kg], by default that of the loop's axis

    Raises
    ------
    UnknownModel, UnknownLaw
        When there is no such compensator.
    UsageError
        When friction is below 0, or the mass not above.
    """
    friction = number("friction", friction)
    if not 0.0 <= friction < math.inf:
        raise UsageError(f"friction = {friction:g} N: expected 0 or more")
    m = loop.axis.m if m is None else number("m", m)
    if not 0.0 < m < math.inf:
        raise UsageError(f"m = {m:g} kg: expected more than 0")
    fmus = Path(folder) / "chain"
    chain = _built(fmus, (), compensators)
    with ChainResponse(fmus, loop, chain) as response:
        return response.of(loop, {}, friction, m)


def _built(
    fmus: Path, others: Sequence[str], compensators: Sequence[Compensator]
) -> list[Compensator]:
    """Build FMUs into a folder; return the compensators with their files."""
    for name in others:
        models.build_fmu(name, fmus)
    files = ["_".join(filter(None, [one.model, one.law])) for one in compensators]
    for one, file in zip(compensators, files, strict=True):
        models.build_fmu(one.model, fmus, law=one.law or None, called=file)
    return [replace(one, file=file) for one, file in zip(compensators, files, strict=True)]
