"""The compensator as a controller takes it: one block from its commands to the force."""

from __future__ import annotations

from dataclasses import replace

from stickslip.servo.systems import Compensator, nominal_parameters
from stickslip.servo.velocity_loop import VelocityLoop

BLOCKS = {"compensator": "command_feedforward", "static_feedforward": "command_static"}
"""Compensator behind a nominal loop -> the model that contains this loop as well."""
_OF_THE_LOOP = ("hold", "T_s")


def deployed(one: Compensator, loop: VelocityLoop | None, T_s: float) -> Compensator:
    """Return a feedforward with the loop without friction in it.

    Parameters
    ----------
    loop : whose controller gives the commands; with None, friction is that of the velocity command
    T_s : sample period of the controller where there is no loop [s]
    """
    values = {"T_s": T_s}
    if loop is not None:
        values = {**loop_values(loop), "lead": loop.axis.tau_i}
    values |= {name: value for name, value in one.values.items() if name not in _OF_THE_LOOP}
    return replace(one, model=BLOCKS[one.model], values=values)


def loop_values(loop: VelocityLoop) -> dict[str, float]:
    """Return the parameters of the loop without friction in a block of ``BLOCKS``.

    The position error of a cascade is the last state. The nominal loop adds T_s v_cmd to it in each
    period; here the change of x_cmd is added instead.
    """
    nominal = nominal_parameters(loop)
    values = {name if name == "T_s" else f"loop_{name}": v for name, v in nominal.items()}
    if loop.K_x:
        values[f"loop_B[{loop.nominal.nstates}]"] -= loop.T_s
        values[f"loop_G[{loop.nominal.nstates}]"] = 1.0
    return values
