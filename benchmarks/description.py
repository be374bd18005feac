"""A description of 100,000 variables: s to load it, and what FMPy takes to read it."""

from pathlib import Path

import fmpy

from benchmarks.coupling import ring
from benchmarks.timing import interleaved
from stickslip import cosim

N = 100_000


def measure(folder: Path) -> dict[str, float]:
    taken = {}
    for version in (2, 3):
        path = ring.build(folder, "mass", version, extra=N)
        cosim.Fmu(path)
        cases = {
            f"cosim.Fmu, FMI {version}.0 (s)": lambda p=path: cosim.Fmu(p),
            f"fmpy.read_model_description, FMI {version}.0 (s)": lambda p=path: (
                fmpy.read_model_description(p, validate=False)
            ),
        }
        taken |= interleaved(cases, 3)
    return taken
