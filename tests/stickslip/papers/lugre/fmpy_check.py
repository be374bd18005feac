"""What FMPy makes of a compensator: its force.

FMPy steps ``compensator.fmu`` alone over the commands of a run of the whole loop. A force that
differs from the recorded one in any bit would mean that other tools do not get the compensator that
was learned.
"""

from collections.abc import Mapping
from pathlib import Path

import fmpy
import numpy as np

from stickslip import cosim
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop
from tests.cosim.single import by_fmpy

RECORDED, OUTPUT = "compensator.F_mean", "F_ff"


def second_opinion(
    fmu: Path, system: cosim.System, loop: VelocityLoop, commands: Mapping[str, Array]
) -> dict[str, tuple[Array, Array]]:
    """Return the force (n,) [N] in the loop and FMPy's, for each of velocity commands (n,) [m/s].

    The FMU is the compensator as it is deployed, the system ``paper_loop`` with it.
    """
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    names = [one.name for one in variables if one.causality == "input"]
    found = {}
    for command, v_cmd in commands.items():
        given, t = loop.commands(v_cmd), loop.T_s * np.arange(len(v_cmd))
        how = {"record": (RECORDED,), "constant_step": True}
        with system.prepare(step=loop.T_s, stop=t[-1], **how) as simulation:
            recorded = simulation.run(inputs=given)[RECORDED]
        absent = np.zeros_like(t)  # a command that the loop does not take
        inputs = [t, *((name, float, given.get(name, absent)) for name in names)]
        found[command] = (recorded, by_fmpy(fmu, loop.T_s, t[-1], OUTPUT, inputs=inputs)[OUTPUT])
    return found
