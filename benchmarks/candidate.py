"""One candidate of the learning (10 s at 2 kHz, four FMUs), relative to our kernel."""

import statistics
import time
from pathlib import Path

from fmpy.fmi2 import FMU2Slave

from benchmarks.loop import INPUTS, specification
from stickslip.cosim.fmu.names import component_of

REPEATS = 11


def measure(folder: Path) -> dict[str, float]:
    spec = specification(folder)
    parameters = {f"compensator.{n}": v for n, v in (("F_c", 5.5), ("sigma_0", 4e5))}
    with spec.prepare() as simulation:
        kernel = _median(lambda: simulation.run(parameters, INPUTS), REPEATS)
        command = INPUTS["v_cmd"].sample(simulation.time)
        order = simulation.order
    python = _median(lambda: _run_with_fmpy(spec, order, command), 1)
    return {"kernel": 1.0, "FMPy's calls from a Python loop": python / kernel}


def _median(run, repeats: int) -> float:
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def _run_with_fmpy(spec, order, command) -> None:
    """Step the same FMUs in the same order as FMPy documents it, reading each output once."""
    system = spec.system
    slaves, inputs, outputs = {}, {}, {}
    for name in order:
        fmu = system.components[name]
        slave = FMU2Slave(
            guid=fmu.token,
            unzipDirectory=str(fmu.folder),
            modelIdentifier=fmu.identifier,
            instanceName=name,
        )
        slave.instantiate()
        for full, value in system.parameters.items():
            if component_of(full) == name:
                variable = system.variable(full)
                setter = slave.setBoolean if variable.type == "Boolean" else slave.setReal
                setter([variable.reference], [value])
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slaves[name] = slave
        feeds = {
            **system.connections,
            **{target: source for source, targets in system.inputs.items() for target in targets},
        }
        wanted = [target for target in feeds if component_of(target) == name]
        inputs[name] = ([system.variable(t).reference for t in wanted], [feeds[t] for t in wanted])
        read = sorted({s for s in feeds.values() if component_of(s) == name})
        outputs[name] = ([system.variable(s).reference for s in read], read)
    values = {source: 0.0 for _, read in outputs.values() for source in read}
    for n, v_cmd in enumerate(command[:-1]):
        values["v_cmd"] = v_cmd
        for name, slave in slaves.items():
            references, sources = inputs[name]
            slave.setReal(references, [values[s] for s in sources])
            slave.doStep(n * spec.step, spec.step)
            references, read = outputs[name]
            values.update(zip(read, slave.getReal(references), strict=True))
    for slave in slaves.values():
        slave.terminate()
        slave.freeInstance()
