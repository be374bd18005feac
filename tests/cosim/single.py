"""Systems of one FMU, and the same FMU in FMPy."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from stickslip import cosim


def one(
    path: Path, parameters: Mapping[str, object] | None = None, u: str = "", **how: object
) -> cosim.System:
    """Return a system of the component ``a``; its input u leads to the variable ``u``."""
    system = cosim.System()
    system.add("a", path, parameters, **how)
    if u:
        system.expose("u", f"a.{u}")
    return system


def by_fmpy(
    path: Path, step: float, stop: float, *output: str, inputs: Any = (), **more: Any
) -> Any:
    """Return what FMPy gives for an FMU.

    Parameters
    ----------
    inputs : time (n,), then (name, type, values (n,)) of each signal
    """
    if inputs:
        time, *signals = inputs
        columns = zip(time, *(values for _, _, values in signals), strict=True)
        names = [("time", "f8"), *((name, kind) for name, kind, _ in signals)]
        more["input"] = np.array(list(columns), dtype=names)
    how = {"fmi_type": "CoSimulation", "stop_time": stop, "output_interval": step, **more}
    return fmpy.simulate_fmu(str(path), output=list(output), **how)
