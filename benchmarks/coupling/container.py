"""Systems as one FMU by FMPy, and FMUs stepped by calls from outside."""

import tempfile
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.container_fmu import config
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.model_description import CoSimulation, ModelDescription, ModelVariable

from stickslip import cosim
from stickslip.cosim.component import component_of


def write(system: cosim.System, path: Path, step: float, output: str) -> Path:
    """Show the exposed inputs and one output; start values of the system are its parameters."""
    parts = {
        name: config.Component(name, fmu.path, read_model_description(fmu.path))
        for name, fmu in system.components.items()
    }
    variables = {
        f"{name}.{variable.name}": variable
        for name, part in parts.items()
        for variable in part.modelDescription.modelVariables
    }
    for variable in variables.values():  # FMPy would write Real, which its binary does not know
        variable.type = {"Real": "Float64", "Integer": "Int32"}.get(variable.type, variable.type)
    shown = {
        output: ("output", "calculated", None, [output]),
        **{name: ("input", None, 0.0, targets) for name, targets in system.inputs.items()},
        **{n: ("parameter", "exact", v, [n]) for n, v in system.parameters.items()},
    }
    time = ModelVariable("time", valueReference=0, type="Real", causality="independent")
    mapping, listed = {}, [time]  # which FMPy's binary has under reference 0
    for reference, (name, (causality, initial, start, targets)) in enumerate(shown.items(), 1):
        variability = "fixed" if causality == "parameter" else "continuous"
        given = {"causality": causality, "initial": initial, "variability": variability}
        given |= {"type": "Boolean" if isinstance(start, bool) else "Real"}
        given |= {"start": None if start is None else str(start).lower()}
        variable = ModelVariable(name=name, valueReference=reference, **given)
        listed.append(variable)
        mapping[variable] = [(parts[component_of(t)], variables[t]) for t in targets]
    description = ModelDescription()
    description.fmiVersion = "2.0"
    description.modelName = description.guid = description.instantiationToken = "container"
    description.coSimulation = CoSimulation(fixedInternalStepSize=step)
    description.modelVariables = listed
    connections = [
        config.Connection(
            parts[component_of(s)], [variables[s]], parts[component_of(t)], [variables[t]]
        )
        for t, s in system.connections.items()
    ]
    configuration = config.Configuration(
        False, description, [*parts.values()], connections, mapping
    )
    with tempfile.TemporaryDirectory() as unpacked:
        create_container_fmu(configuration, Path(unpacked), path)
    return path


def slave(path: Path, name: str) -> FMU2Slave:
    """Load and instantiate an FMU 2.0."""
    description = read_model_description(path)
    found = FMU2Slave(
        guid=description.guid,
        unzipDirectory=extract(path),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=name,
    )
    found.instantiate()
    return found


def start(slave: FMU2Slave) -> FMU2Slave:
    """Initialise an instance at time 0."""
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    return slave
