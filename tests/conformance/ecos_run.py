"""Run one FMU in ecos and print the last values of its outputs.

Arguments: file, step (s), number of steps, inputs as JSON, outputs as JSON. A process of its own,
because ecos needs the library folder of its neighbour tbb on the loader's path.
"""

import json
import sys

from ecospy import EcosSimulation, EcosSimulationStructure

path, step, steps, inputs, outputs = sys.argv[1:]
structure = EcosSimulationStructure()
structure.add_model("fmu", path)
starts = {f"fmu::{name}": value for name, value in json.loads(inputs).items()}
structure.add_parameter_set("starts", starts)
simulation = EcosSimulation(step_size=float(step), structure=structure)
simulation.init(parameter_set="starts")
simulation.step(int(steps))
values = [simulation.get_real(f"fmu::{name}") for name in json.loads(outputs)]
sys.stdout.write(json.dumps(values) + "\n")
simulation.terminate()
