"""The pendulum of pendulum.c as an FMU of Model Exchange, and its linearisation by hand."""

from __future__ import annotations

import os
import re
import zipfile
from pathlib import Path

import fmpy
import numpy as np

from stickslip.fmi import toolchain

# name, causality, start, value reference of the state it is the derivative of
_VARIABLES = [
    ("theta", "local", 0.0, None),
    ("omega", "local", 0.0, None),
    ("torque", "input", 0.0, None),
    ("k", "parameter", 9.81, None),
    ("drag", "parameter", 0.0, None),
    ("x", "output", None, None),
    ("power", "output", None, None),
    ("der(theta)", "local", None, 0),
    ("der(omega)", "local", None, 1),
]


def pendulum(folder: Path, version: int, derivatives: bool) -> Path:
    """Write the FMU; with ``derivatives`` it declares its directional derivatives."""
    headers = Path(fmpy.__file__).parent / "c-code"
    files = {f"system/{h.name}": h.read_text() for h in headers.glob("fmi[23]*.h")}
    files["pendulum.c"] = Path(__file__).with_name("pendulum.c").read_text()
    # What the standard requires and nobody calls.
    wanted = re.findall(r"FMI[23]_Export fmi[23]\w+TYPE\s+(\w+);", "".join(files.values()))
    absent = [name for name in wanted if f" {name}(" not in files["pendulum.c"]]
    export = (
        "__declspec(dllexport)" if os.name == "nt" else '__attribute__((visibility("default")))'
    )
    files["absent.c"] = "\n".join(f"{export} int {name}(void) {{ return 3; }}" for name in absent)
    flags = ("-Wno-unused-parameter", "-Wno-missing-prototypes")
    library = toolchain.shared_library("pendulum", files, flags=flags)
    platform = toolchain.host_platform()
    place = platform.fmi2 if version == 2 else platform.tuple
    path = folder / f"pendulum{version}{derivatives:d}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", _description(version, derivatives))
        archive.write(library, f"binaries/{place}/{library.name}")
    return path


def by_hand(theta: float, omega: float, torque: float, k: float, drag: float):
    """Return A, B, C, D of the pendulum at a point."""
    A = np.array([[0.0, 1.0], [-k * np.cos(theta), -2 * drag * abs(omega)]])
    C = np.array([[np.cos(theta), 0.0], [0.0, torque]])
    return A, np.array([[0.0], [1.0]]), C, np.array([[0.0], [omega]])


def _description(version: int, derivatives: bool) -> str:
    texts = []
    for reference, (name, causality, start, state) in enumerate(_VARIABLES):
        variability = "fixed" if causality == "parameter" else "continuous"
        typed = f' start="{start}"' if start is not None else ""
        if state is not None:
            typed += f' derivative="{state + 1 if version == 2 else state}"'
        initial = ' initial="exact"' if causality == "local" and start is not None else ""
        common = f'name="{name}" valueReference="{reference}" causality="{causality}"'
        common += f' variability="{variability}"{initial}'
        texts.append(
            f"<ScalarVariable {common}><Real{typed}/></ScalarVariable>"
            if version == 2
            else f"<Float64 {common}{typed}/>"
        )
    plural = "s" if version == 3 else ""
    flag = f' providesDirectionalDerivative{plural}="true"' if derivatives else ""
    if version == 2:
        root = 'fmiVersion="2.0" guid="pendulum"'
        structure = (
            '<Outputs><Unknown index="6"/><Unknown index="7"/></Outputs>'
            '<Derivatives><Unknown index="8"/><Unknown index="9"/></Derivatives>'
        )
    else:
        root = 'fmiVersion="3.0" instantiationToken="pendulum"'
        texts.append(
            '<Float64 name="time" valueReference="99" causality="independent"'
            ' variability="continuous"/>'
        )
        structure = '<Output valueReference="5"/><Output valueReference="6"/>'
        structure += "".join(f'<ContinuousStateDerivative valueReference="{r}"/>' for r in (7, 8))
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription {root} modelName="pendulum">'
        f'<ModelExchange modelIdentifier="pendulum"{flag}/><ModelVariables>{"".join(texts)}'
        f"</ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
