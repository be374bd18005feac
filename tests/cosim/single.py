"""Systems of FMUs, one FMU in FMPy, runs in two halves, and archives packed again."""

import re
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from stickslip import cosim
from tests.corpus.fmu import archive


def one(
    path: Any,
    parameters: Mapping[str, object] | None = None,
    u: str = "",
    name: str = "a",
    **how: object,
) -> cosim.System:
    """Return a system of one component; its input u leads to the variable ``u``."""
    system = cosim.System()
    system.add(name, path, parameters, **how)
    if u:
        system.expose("u", f"{name}.{u}")
    return system


def joined(
    parts: Mapping[str, Any], *wires: str, name: str = "joined", **inputs: str
) -> cosim.System:
    """Return a system of FMUs, or pairs of FMU and parameters, joined by ``"a.y b.u"``.

    An input of the system leads to one or more variables: ``u="a.u b.u"``.
    """
    system = cosim.System(name)
    for part, given in parts.items():
        system.add(part, *(given if isinstance(given, tuple) else (given,)))
    for wire in wires:
        system.connect(*wire.split())
    for known, targets in inputs.items():
        system.expose(known, *targets.split())
    return system


def exposed(
    path: Path, parameters: Mapping[str, object] | None = None, name: str = "a", **how: object
) -> cosim.System:
    """Return a system of one component, whose inputs are exposed under their own names."""
    system = cosim.System(name)
    system.add(name, path, parameters, **how)
    for variable in system.components[name].variables.values():
        if variable.causality == "input":
            system.expose(variable.name, f"{name}.{variable.name}")
    return system


def by_fmpy(
    path: Path, step: float, stop: float, *output: str, inputs: Any = (), **more: Any
) -> Any:
    """Return what FMPy gives for the outputs of an FMU that are named, or for all.

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
    return fmpy.simulate_fmu(str(path), output=list(output) or None, **how)


def saves(version: int) -> str:
    """Return what an FMU declares whose state can be saved."""
    word = "FMUstate" if version == 2 else "FMUState"
    return f'canGetAndSet{word}="true" canSerialize{word}="true"'


def halves(
    system: cosim.System,
    path: Path,
    *given: Any,
    until: float,
    tunable: dict[str, Any] | None = None,
    **how: Any,
) -> tuple[cosim.Result, cosim.Result]:
    """Return a whole run, and the rest of one that was halted, saved and resumed elsewhere.

    Parameters
    ----------
    given : parameters and inputs
    """
    with system.prepare(**how) as simulation:
        whole = simulation.run(*given, tunable=tunable)
        effort = dict(simulation.effort)
        begun = simulation.run(*given, tunable=tunable, until=until)
        np.testing.assert_array_equal(begun.values, whole.values[: len(begun.time)])
        simulation.save(path)
    with system.prepare(**how) as another:
        rest = another.resume(path, *given[1:], tunable=tunable)
        assert another.effort == effort
    return whole, rest


def members(path: Path) -> dict[str, bytes]:
    """Return the members of an archive."""
    with zipfile.ZipFile(path) as file:
        return {name: file.read(name) for name in file.namelist()}


def repacked(
    path: Path,
    other: Path,
    change: Callable[[str, bytes], bytes | None],
    renamed: Callable[[str], str] = str,
) -> Path:
    """Pack the members of an archive again, some changed, renamed, or left out (None)."""
    changed = {renamed(name): change(name, data) for name, data in members(path).items()}
    return archive(other, {name: data for name, data in changed.items() if data is not None})


def edited(
    path: Path, other: Path, changes: Mapping[str, str], member: str = "modelDescription.xml"
) -> Path:
    """Return a copy of an archive in which one file has other texts, by patterns."""

    def change(name: str, data: bytes) -> bytes:
        for pattern, text in changes.items() if name == member else ():
            data, n = re.subn(pattern.encode(), text.encode(), data, flags=re.DOTALL)
            assert n
        return data

    return repacked(path, other, change)
