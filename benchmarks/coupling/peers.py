"""The ring with every other master that pip installs: each returns the CPU time of n steps (s)."""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks import fmpy_container as sealed
from benchmarks.coupling import ring
from stickslip import cosim

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
    slaves = {
        name: sealed.start(sealed.slave(ring.build(folder, name, 2), name)) for name in ring.MODELS
    }
    begin = time.process_time()
    for k in range(n):
        moved = [
            (target, slaves[source[0]].getReal([REFERENCE[tuple(source)]]))
            for source, target in LINKS
        ]
        for (name, variable), values in moved:
            slaves[name].setReal([REFERENCE[name, variable]], values)
        for slave in slaves.values():
            slave.doStep(k * ring.STEP, ring.STEP)
    return time.process_time() - begin


def fmpy_container(folder: Path, n: int) -> float:
    """All three sealed in one FMU, stepped by one call."""
    path = folder / "fmpy.fmu"
    if not path.exists():
        sealed.write(ring.system(folder, 2), path, ring.STEP, "mass.v")
    return _one_call(path, n)


def our_container(folder: Path, n: int) -> float:
    """The same by cosim."""
    path = folder / "stickslip.cosim.fmu.fmu"
    if not path.exists():
        cosim.write_fmu(ring.system(folder, 2), path, step=ring.STEP, coupling="jacobi")
    return _one_call(path, n)


def toolbox_container(folder: Path, n: int) -> float:
    """All three sealed in one FMU by fmu-manipulation-toolbox, stepped by one call."""
    path = folder / "fmi2-0" / "sealed.fmu"
    if not path.exists():
        for name in ring.MODELS:
            ring.build(folder, name, 2)
        recipe = {
            "name": path.name,
            "fmu": [f"{name}.fmu" for name in ring.MODELS],
            "link": [
                [f"{s}.fmu", source, f"{t}.fmu", target] for (s, source), (t, target) in LINKS
            ],
            "output": [["mass.fmu", "x", "x"]],
            "step_size": ring.STEP,
        }
        (path.parent / "sealed.json").write_text(json.dumps(recipe))
        run = "from fmu_manipulation_toolbox.cli.fmucontainer import fmucontainer; fmucontainer()"
        command = [sys.executable, "-c", run, "-container", "sealed.json"]
        done = subprocess.run(
            [*command, "-fmu-directory", str(path.parent)], capture_output=True, text=True
        )
        if not path.exists():
            raise RuntimeError(f"fmucontainer built nothing: {(done.stderr or done.stdout)[-200:]}")
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
        execution.connect_real_variables(
            slaves[s], REFERENCE[s, source], slaves[t], REFERENCE[t, target]
        )
    begin = time.process_time()
    execution.step(step_count=n)
    return time.process_time() - begin


PEERS: dict[str, tuple[Callable[[Path, int], float], int]] = {  # and how many steps to time
    "cosim container FMU, one doStep": (our_container, 100_000),
    "FMPy container FMU, one doStep": (fmpy_container, 100_000),
    "fmu-manipulation-toolbox container, one doStep": (toolbox_container, 100_000),
    "FMPy from Python": (fmpy_from_python, 5_000),
    "libcosimpy": (libcosimpy, 5_000),
}


def _one_call(path: Path, n: int) -> float:
    slave = sealed.start(sealed.slave(path, path.stem))
    begin = time.process_time()
    slave.doStep(0.0, n * ring.STEP)
    return time.process_time() - begin
