"""Run an FMU, or a package with its parameter sets, in ecos; print the last values of outputs.

Arguments: file, step (s), number of steps, inputs of an FMU as JSON, outputs as JSON. A process of
its own, because ecos needs the library folder of its neighbour tbb on the loader's path.
"""

import json
import sys

from ecospy import EcosSimulation, EcosSimulationStructure

path, step, steps, inputs, outputs = sys.argv[1:]
if path.endswith(".ssp"):
    simulation, prefix = EcosSimulation(step_size=float(step), ssp_path=path), ""
else:
    structure, prefix = EcosSimulationStructure(), "fmu::"
    structure.add_model("fmu", path)
    starts = {f"fmu::{name}": value for name, value in json.loads(inputs).items()}
    structure.add_parameter_set("parameters", starts)
    simulation = EcosSimulation(step_size=float(step), structure=structure)
simulation.init(parameter_set="parameters")
simulation.step(int(steps))
values = [simulation.get_real(f"{prefix}{name}") for name in json.loads(outputs)]
sys.stdout.write(json.dumps(values) + "\n")
simulation.terminate()
