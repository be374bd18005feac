"""The FMU of ``faults.c``, which fails where it is told to."""

from __future__ import annotations

import zipfile
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Literal

from stickslip.fmi import toolchain

Kind = Literal["plain", "typed", "exchange", "events"]
"""Co-Simulation with doubles alone, or an integer as well; Model Exchange; event mode (FMI 3.0)."""

ARMED_ELSEWHERE = "armed elsewhere"
_FLAGS = ("-Wno-unused-parameter", "-Wno-variadic-macro-arguments-omitted", "-Wno-pedantic")


@cache
def library(environment: str = "m->environment") -> Path:
    """Return the compiled FMU, one for all versions and kinds.

    ``environment`` is a C expression: what it passes to the logger as its environment.
    """
    headers = resources.files("fmpy") / "c-code"
    files = {
        f"system/{h.name}": h.read_text(encoding="utf-8")
        for h in headers.iterdir()
        if h.name.startswith(("fmi2", "fmi3"))
    }
    files["faults.c"] = Path(__file__).with_name("faults.c").read_text(encoding="utf-8")
    flags = (*_FLAGS, f"-DENVIRONMENT={environment}")
    return toolchain.shared_library("faults", files, flags=flags)


def describe(plan: str, version: int, kind: Kind) -> str:
    """Return modelDescription.xml; ``plan`` is the token."""
    type_, whole = ("Real", "Integer") if version == 2 else ("Float64", "Int32")
    rows = [
        ("u", type_, 'causality="input"', 'start="0"'),
        ("y", type_, 'causality="output"', ""),
        ("x", type_, 'causality="local"', ""),
        ("der(x)", type_, 'causality="local"', 'derivative="X"'),
        ("k", type_, 'causality="parameter" variability="fixed"', 'start="1"'),
        ("n", whole, 'causality="output" variability="discrete"', ""),
    ][: 6 if kind == "typed" else 5]
    variables, outputs = "", ""
    for i, (name, kind_, cause, more) in enumerate(rows):
        more = more.replace("X", "3" if version == 2 else "2")
        head = f'name="{name}" valueReference="{i}" {cause}'
        variables += (
            f"<ScalarVariable {head}><{kind_} {more}/></ScalarVariable>"
            if version == 2
            else f"<{kind_} {head} {more}/>"
        )
        if "output" in cause:
            outputs += (
                f'<Unknown index="{i + 1}" dependencies=""/>'
                if version == 2
                else f'<Output valueReference="{i}" dependencies=""/>'
            )
    word = "state" if version == 2 else "State"
    flags = f'modelIdentifier="faults" canGetAndSetFMU{word}="true" canSerializeFMU{word}="true"'
    if kind == "exchange":
        interface = f'<ModelExchange {flags} needsCompletedIntegratorStep="true"/>'
    else:
        interface = f'<CoSimulation {flags} canHandleVariableCommunicationStepSize="true"/>'
    if version == 3:
        if kind == "events":
            interface = interface.replace("/>", ' hasEventMode="true"/>')
        variables += (
            '<Float64 name="time" valueReference="9" causality="independent"'
            ' variability="continuous"/>'
        )
        structure = outputs + '<ContinuousStateDerivative valueReference="3"/>'
        key = "instantiationToken"
    else:
        structure = f'<Outputs>{outputs}</Outputs><Derivatives><Unknown index="4"/></Derivatives>'
        key = "guid"
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="{version}.0"'
        f' {key}="{plan}" modelName="faults">{interface}'
        '<DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/>'
        f"<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def write(
    path: Path,
    plan: str,
    version: int = 2,
    kind: Kind = "plain",
    environment: str = "m->environment",
) -> Path:
    """Write an FMU that fails as planned: ``FUNCTION NTH STATUS``, or ARMED_ELSEWHERE.

    ``environment`` is a C expression: what it passes to the logger as its environment.
    """
    platform = toolchain.host_platform()
    place = platform.fmi2 if version == 2 else platform.tuple
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", describe(plan, version, kind))
        binary = library(environment)
        archive.write(binary, f"binaries/{place}/{binary.name}")
    return path
