"""FMUs that misbehave as they are told, all of one library."""

from __future__ import annotations

import re
import zipfile
from functools import cache
from pathlib import Path

import fmpy

from stickslip.fmi import toolchain

_VARIABLES = [("u", "input", 1.0), ("y", "output", 0.0), ("k", "parameter", 1.0)]
_VARIABLES += [("fragile", "parameter", 0.0)]


@cache
def library() -> bytes:
    """Return the library of hostile.c."""
    headers = Path(fmpy.__file__).parent / "c-code"
    files = {f"system/{h.name}": h.read_text() for h in headers.glob("fmi[23]*.h")}
    model = Path(__file__).with_name("hostile.c").read_text()
    names = set(re.findall(r"FMI[23]_Export fmi[23]\w+TYPE\s+(\w+);", "".join(files.values())))
    absent = sorted(name for name in names if f"{name}(" not in model)
    export = '__attribute__((visibility("default"))) int'
    files["absent.c"] = "\n".join(f"{export} {name}(void) {{ return 3; }}" for name in absent)
    files["hostile.c"] = model
    flags = ("-Wno-infinite-recursion", "-Wno-null-dereference", "-lpthread", "-ldl", "-lm")
    return toolchain.shared_library("hostile", files, flags=flags).read_bytes()


def write(
    path: Path,
    behaviour: str = "",
    *,
    version: int = 2,
    token: str = "hostile",  # noqa: S107 - that of FMI
    binaries: dict[str, bytes] | None = None,
    flags: str = "",
) -> Path:
    """Write an FMU.

    Parameters
    ----------
    behaviour : call, what it does, and at the how-manieth time: ``DoStep segv 3``
    binaries : name in the archive -> content; the library for this machine by default
    flags : further attributes of its interface
    """
    if binaries is None:
        binaries = {place(version): library()}
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", _description(version, token, flags))
        archive.writestr("resources/behaviour.txt", behaviour)
        for name, content in binaries.items():
            archive.writestr(name, content)
    return path


def place(version: int = 2, name: str = "hostile") -> str:
    """Return where a library for this machine lies."""
    platform = toolchain.host_platform()
    folder = platform.fmi2 if version == 2 else platform.tuple
    return f"binaries/{folder}/{name}{platform.suffix}"


def _description(version: int, token: str, flags: str) -> str:
    variables = []
    for reference, (name, causality, start) in enumerate(_VARIABLES):
        varies = "fixed" if causality == "parameter" else "continuous"
        common = (
            f'name="{name}" valueReference="{reference}" causality="{causality}"'
            f' variability="{varies}"'
        )
        if causality == "output":
            common += ' initial="exact"'
        if version == 2:
            variables.append(f'<ScalarVariable {common}><Real start="{start}"/></ScalarVariable>')
        else:
            variables.append(f'<Float64 {common} start="{start}"/>')
    if version == 2:
        named, structure = "guid", '<Outputs><Unknown index="2" dependencies=""/></Outputs>'
    else:
        variables.append(
            '<Float64 name="time" valueReference="99" causality="independent"'
            ' variability="continuous"/>'
        )
        named, structure = "instantiationToken", '<Output valueReference="1" dependencies=""/>'
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<fmiModelDescription fmiVersion="{version}.0" modelName="hostile" {named}="{token}">'
        '<CoSimulation modelIdentifier="hostile" canHandleVariableCommunicationStepSize="true"'
        f" {flags}/>"
        '<DefaultExperiment startTime="0" stopTime="0.1" stepSize="0.01"/>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
