"""What FMPy makes of a compensator: its force.

FMPy steps ``compensator.fmu`` alone over the commands of a run of the whole loop. A force that
differs from the recorded one in any bit would mean that other tools do not get the compensator that
was learned.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np

from stickslip import cosim
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop

RECORDED, OUTPUT = "compensator.F_mean", "F_ff"


@dataclass(frozen=True)
class Comparison:
    """One run of the loop, and FMPy over the same commands."""

    samples: int  # values of the force that were compared, the initial one included
    different: int  # how many of them are not the same double
    largest: float  # difference [N]


def second_opinion(
    fmu: Path, system: cosim.System, loop: VelocityLoop, commands: Mapping[str, Array]
) -> dict[str, Comparison]:
    """Run the loop over velocity commands (n,) [m/s], and the compensator alone in FMPy.

    The FMU is the compensator as it is deployed, the system ``paper_loop`` with it.
    """
    comparisons = {}
    for name, v_cmd in commands.items():
        given, stop = loop.commands(v_cmd), (len(v_cmd) - 1) * loop.T_s
        with system.prepare(
            step=loop.T_s, stop=stop, record=(RECORDED,), constant_step=True
        ) as simulation:
            recorded = simulation.run(inputs=given)[RECORDED]
        force = _stepped_by_fmpy(fmu, given, loop.T_s)
        difference = np.abs(force - recorded)
        unlike = force.view(np.int64) != recorded.view(np.int64)
        comparisons[name] = Comparison(len(force), int(unlike.sum()), float(difference.max()))
    return comparisons


def _stepped_by_fmpy(fmu: Path, commands: Mapping[str, Array], T_s: float) -> Array:
    """Return the force (n,) [N] over commands (n,), each set at the beginning of its step.

    A command that the loop does not take is 0.
    """
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    names = [one.name for one in variables if one.causality == "input"]
    table = np.zeros(len(commands["v_cmd"]), [(name, float) for name in ("time", *names)])
    table["time"] = T_s * np.arange(len(table))
    for name, values in commands.items():
        table[name] = values
    result = fmpy.simulate_fmu(
        str(fmu),
        fmi_type="CoSimulation",
        start_time=0.0,
        stop_time=table["time"][-1],
        output_interval=T_s,
        input=table,
        output=[OUTPUT],
    )
    return np.ascontiguousarray(result[OUTPUT], dtype=float)
