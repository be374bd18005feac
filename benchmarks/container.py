"""The paper's loop (10 s at 2 kHz) as one FMU, stepped by one call, relative to our kernel."""

from pathlib import Path

import numpy as np

from benchmarks import fmpy_container
from benchmarks.loop import STOP, specification
from benchmarks.timing import interleaved
from stickslip import cosim

REPEATS = 21


def measure(folder: Path) -> dict[str, float]:
    spec = specification(folder)
    system, step, command = spec.system, spec.step, {"v_cmd": 0.005}
    ours, theirs = (
        fmpy_container.Instance(path)
        for path in (
            cosim.write_fmu(system, folder / "ours.fmu", step=step),
            fmpy_container.write(system, folder / "theirs.fmu", step, "drive.v"),
        )
    )
    tables, compiled = (
        system.prepare(step=step, stop=STOP, record=["drive.v"], compiled=compiled)
        for compiled in (False, True)
    )
    jacobi = system.prepare(step=step, stop=STOP, record=["drive.v"], coupling="jacobi")
    cases = {
        "kernel": lambda: tables.run(inputs=command)["drive.v"][-1],
        "kernel, compiled": lambda: compiled.run(inputs=command)["drive.v"][-1],
        "cosim's container": lambda: ours.run(STOP, "drive.v", **command),
        "kernel, Jacobi": lambda: jacobi.run(inputs=command)["drive.v"][-1],
        "FMPy's container, Jacobi": lambda: theirs.run(STOP, "drive.v", **command),
    }
    ends = {name: run() for name, run in cases.items()}
    if ends["cosim's container"] != ends["kernel"]:
        raise RuntimeError(f"the container is not the kernel: {ends}")
    np.testing.assert_allclose(ends["FMPy's container, Jacobi"], ends["kernel, Jacobi"], rtol=1e-9)
    seconds = interleaved(cases, REPEATS)
    return {name: seconds[name] / seconds["kernel"] for name in cases}
