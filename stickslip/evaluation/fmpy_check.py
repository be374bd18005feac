"""What FMPy makes of the compensator that was learned: its description, and its force.

FMPy steps ``compensator.fmu`` alone over the velocities that the compensator had in a run of the
whole loop. A force that differs from the recorded one in any bit would mean that other tools do
not get the compensator that was learned.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from stickslip import cosim, models
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop

INPUT, OUTPUT = "compensator.v", "compensator.F_mean"


@dataclass(frozen=True)
class Comparison:
    """One run of the loop, and FMPy over the same velocities.

    Attributes
    ----------
    samples : values of F_mean that were compared, the initial one included
    different : how many of them are not the same double
    largest : largest difference [N]
    """

    samples: int
    different: int
    largest: float


@dataclass(frozen=True)
class FmuVariable:
    """A variable of an FMU as its description has it; what it does not have is empty."""

    name: str
    causality: str
    unit: str
    start: str
    description: str


@dataclass(frozen=True)
class SecondOpinion:
    """What FMPy says of an FMU.

    Attributes
    ----------
    tool : name and version
    description : what the FMU says of itself: name, FMI version, interfaces, ...
    comparisons : by the name of the command that was run
    """

    tool: str
    description: Mapping[str, str]
    variables: tuple[FmuVariable, ...]
    comparisons: Mapping[str, Comparison]


def second_opinion(
    fmu: Path, system: cosim.System, loop: VelocityLoop, commands: Mapping[str, Array]
) -> SecondOpinion:
    """Run the loop over velocity commands, and the compensator alone in FMPy.

    Parameters
    ----------
    fmu : the compensator by itself, with what was learned as its start values
    system : ``paper_loop`` with the same compensator. What it sets beside the learned parameters,
        how the compensator is timed, FMPy sets as well.
    commands : by name (n,) [m/s], one value a sample
    """
    ports = models.load_model("compensator").ports
    timed = ports.axis if ports else {}
    timing = {
        variable: value
        for key, value in system.parameters.items()
        for component, _, variable in [key.partition(".")]
        if component == "compensator" and variable in timed
    }
    comparisons = {}
    for name, v_cmd in commands.items():
        stop = (len(v_cmd) - 1) * loop.T_s
        with system.prepare(step=loop.T_s, stop=stop, record=(INPUT, OUTPUT)) as simulation:
            run = simulation.run(inputs=loop.commands(v_cmd))
        force = _stepped_by_fmpy(fmu, run[INPUT], loop.T_s, timing)
        difference = np.abs(force - run[OUTPUT])
        unlike = force.view(np.int64) != run[OUTPUT].view(np.int64)
        comparisons[name] = Comparison(len(force), int(unlike.sum()), float(difference.max()))
    description, variables = _described(fmu)
    return SecondOpinion(f"FMPy {version('fmpy')}", description, variables, comparisons)


def _stepped_by_fmpy(fmu: Path, v: Array, T_s: float, start: Mapping[str, object]) -> Array:
    """Return F_mean (n,) [N] over recorded velocities (n,) [m/s].

    The recorded ``v[k]`` is what the step that ends at sample k had as its input. FMPy sets inputs
    at the beginning of a step, by interpolation: so the table gives ``v[k]`` at sample k - 1. At
    the first sample it jumps from the value of the initialization to that of the first step.
    """
    import fmpy  # takes half a second, and only this needs it

    t = np.arange(len(v)) * T_s
    table = np.zeros(len(v) + 1, dtype=[("time", float), ("v", float)])
    table["time"] = np.concatenate([[-T_s, 0.0], t[:-1]])
    table["v"] = np.concatenate([v[:1], v[:1], v[1:]])
    result = fmpy.simulate_fmu(
        str(fmu),
        fmi_type="CoSimulation",
        start_time=0.0,
        stop_time=t[-1],
        output_interval=T_s,
        start_values=dict(start),
        input=table,
        output=["F_mean"],
    )
    return np.ascontiguousarray(result["F_mean"], dtype=float)


def _described(fmu: Path) -> tuple[dict[str, str], tuple[FmuVariable, ...]]:
    import fmpy

    description = fmpy.read_model_description(str(fmu))
    interfaces = {
        "Co-Simulation": description.coSimulation,
        "Model Exchange": description.modelExchange,
    }
    head = {
        "name": description.modelName,
        "FMI version": description.fmiVersion,
        "interfaces": ", ".join(name for name, there in interfaces.items() if there is not None),
        "made by": description.generationTool,
        "version": description.version,
        "token": description.guid or description.instantiationToken,
        "description": description.description,
    }
    variables = tuple(
        FmuVariable(
            v.name, v.causality or "local", v.unit or "", v.start or "", v.description or ""
        )
        for v in description.modelVariables
    )
    return {key: value or "–" for key, value in head.items()}, variables
