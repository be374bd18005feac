"""What a step of the ring costs, and one candidate, relative to the plain C loop; other masters."""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.container_fmu import config
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.model_description import CoSimulation, ModelDescription, ModelVariable

from benchmarks.common import interleaved
from benchmarks.coupling import ring
from benchmarks.coupling.ring import Loops
from stickslip import cosim
from stickslip.cosim.component import component_of


def write_by_fmpy(system: cosim.System, path: Path, step: float, output: str) -> Path:
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


LINKS = [
    (source.split("."), target.split("."))
    for source, targets in ring.FEEDS.items()
    for target in ([targets] if isinstance(targets, str) else targets)
]
REFERENCE = {
    (name, line.split()[0]): reference
    for name, lines in ring.MODELS.items()
    for reference, line in enumerate(lines)
}


def fmpy_from_python(folder: Path, n: int) -> float:
    """Step by step, with lists, as its documentation shows."""
    slaves = {name: start(slave(ring.build(folder, name, 2), name)) for name in ring.MODELS}
    begin = time.process_time()
    for k in range(n):
        moved = [
            (target, slaves[source[0]].getReal([REFERENCE[tuple(source)]]))
            for source, target in LINKS
        ]
        for (name, variable), values in moved:
            slaves[name].setReal([REFERENCE[name, variable]], values)
        for one in slaves.values():
            one.doStep(k * ring.STEP, ring.STEP)
    return time.process_time() - begin


def fmpy_container(folder: Path, n: int) -> float:
    """All three sealed in one FMU, stepped by one call."""
    path = folder / "fmpy.fmu"
    if not path.exists():
        write_by_fmpy(ring.system(folder, 2), path, ring.STEP, "mass.v")
    return _one_call(path, n)


def our_container(folder: Path, n: int) -> float:
    """The same by cosim."""
    path = folder / "stickslip.cosim.fmu.fmu"
    if not path.exists():
        cosim.write_fmu(ring.system(folder, 2), path, step=ring.STEP, coupling="jacobi")
    return _one_call(path, n)


def libcosimpy(folder: Path, n: int) -> float:
    """libcosim's fixed step algorithm."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.FATAL)
    execution = CosimExecution.from_step_size(round(ring.STEP * 1e9))
    slaves = {}
    for name in ring.MODELS:
        path = str(ring.build(folder, name, 2))
        slave = CosimLocalSlave(fmu_path=path, instance_name=name)
        slaves[name] = execution.add_local_slave(local_slave=slave)
    for (s, source), (t, target) in LINKS:
        ends = slaves[s], REFERENCE[s, source], slaves[t], REFERENCE[t, target]
        execution.connect_real_variables(*ends)
    begin = time.process_time()
    execution.step(step_count=n)
    return time.process_time() - begin


PEERS: dict[str, tuple[Callable[[Path, int], float], int]] = {  # and how many steps to time
    "cosim container FMU, one doStep": (our_container, 100_000),
    "FMPy container FMU, one doStep": (fmpy_container, 100_000),
    "FMPy from Python": (fmpy_from_python, 5_000),
    "libcosimpy": (libcosimpy, 5_000),
}


def _one_call(path: Path, n: int) -> float:
    one = start(slave(path, path.stem))
    begin = time.process_time()
    one.doStep(0.0, n * ring.STEP)
    return time.process_time() - begin


N = 100_000  # steps
CANDIDATE = 10_000
PLAIN = "plain C loop, Jacobi"
IN_TURN = "plain C loop, Gauss-Seidel"
CANDIDATE_LOOP = "C loop with reset, Jacobi"
CANDIDATE_IN_TURN = "C loop with reset, Gauss-Seidel"


def measure(folder: Path, version: int) -> dict[str, float]:
    """Return the seconds of N steps by who steps them."""
    loops = Loops(version)
    system = ring.system(folder, version)
    cases: dict[str, Callable[[], object]] = {
        "fused C loop, no FMI": lambda: loops.fused(N),
        PLAIN: lambda: loops.plain(N),
        IN_TURN: lambda: loops.in_turn(N),
        "calls alone, Gauss-Seidel": lambda: loops.calls_in_turn(N),
    }
    for name, options in {
        "cosim, Jacobi": {"coupling": "jacobi"},
        "cosim, Jacobi, two signals recorded": {"coupling": "jacobi", "record": ["mass.*"]},
        "cosim, Gauss-Seidel": {},
        "cosim, Gauss-Seidel, two signals recorded": {"record": ["mass.*"]},
    }.items():
        for compiled in (False, True):
            simulation = _prepare(system, N, compiled=compiled, **options)
            cases[name + ", compiled" * compiled] = simulation.run
    np.testing.assert_array_equal(loops.plain(N), cases["cosim, Jacobi"]().values[1:])
    np.testing.assert_array_equal(loops.in_turn(N), cases["cosim, Gauss-Seidel"]().values[1:])
    return interleaved(cases, 21, time.thread_time, min, warm=2)


def measure_candidate(folder: Path, version: int) -> dict[str, float]:
    """Return the seconds of one candidate: reset, set two parameters, run, read the cost."""
    loops = Loops(version)
    gains = {"controller.K_p": 41.0, "controller.K_i": 910.0}
    system = ring.system(folder, version)

    def cost_of(simulation) -> float:
        error = 0.2 - simulation.run(gains)["mass.v"][1:]
        return float(error @ error)

    cases: dict[str, Callable[[], float]] = {
        CANDIDATE_LOOP: lambda: loops.candidate(CANDIDATE, *gains.values()),
        CANDIDATE_IN_TURN: lambda: loops.candidate(CANDIDATE, *gains.values(), turns=True),
    }
    for coupling, order in (("jacobi", ", Jacobi"), ("gauss_seidel", ", Gauss-Seidel")):
        for compiled in (False, True):
            how = {"coupling": coupling, "record": "mass.v", "compiled": compiled}
            simulation = _prepare(system, CANDIDATE, **how)
            case = "cosim" + order + ", compiled" * compiled
            cases[case] = lambda s=simulation: cost_of(s)
    for name, case in cases.items():
        loop = CANDIDATE_IN_TURN if "Gauss-Seidel" in name else CANDIDATE_LOOP
        np.testing.assert_allclose(case(), cases[loop](), rtol=1e-12)
    return interleaved(cases, 61, time.thread_time, min, warm=2)


def measure_peers(folder: Path) -> dict[str, float]:
    """Return the seconds of N steps of every peer that is installed."""
    seconds = {}
    for name, (run, n) in PEERS.items():
        try:
            seconds[name] = np.median([run(folder, n) for _ in range(5)]) * N / n
        except (ImportError, OSError, RuntimeError) as reason:
            print(f"  {name}: left out: {reason}")
    return seconds


def _prepare(system, steps: int, **options):
    return system.prepare(step=ring.STEP, stop=steps * ring.STEP, constant_step=True, **options)
