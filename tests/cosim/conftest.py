"""Small FMUs made on the spot: a gain (direct feedthrough) and an integrator."""

from __future__ import annotations

import os
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

from stickslip.fmi import toolchain

# name, type, causality, unit, further attributes; the value reference is the place in the list
VARIABLES = [
    ("u", "Real", "input", "N", 'start="0"'),
    ("y", "Real", "output", "N", ""),
    ("k", "Real", "parameter", None, 'start="1" min="-1000" max="1000"'),
    ("fault_time", "Real", "parameter", "s", 'start="1e9"'),
    ("sum", "Real", "output", None, ""),
    ("fault", "Integer", "parameter", None, 'start="0"'),
    ("n", "Integer", "parameter", None, 'start="0" min="0" max="9"'),
    ("flag", "Boolean", "parameter", None, 'start="false"'),
    ("text", "String", "parameter", None, 'start=""'),
]
FMI3_TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
UNITS = {
    "N": 'kg="1" m="1" s="-2"',
    "kg.m/s2": 'kg="1" m="1" s="-2"',
    "mN": 'kg="1" m="1" s="-2" factor="0.001"',
    "m": 'm="1"',
    "s": 's="1"',
    "K": 'K="1"',
    "degC": 'K="1" offset="273.15"',
    "degF": 'K="1" factor="0.5555555555555556" offset="255.3722222222222"',
}
RELATIVE = " difference"  # after the name of a unit


TYPES = {
    2: '<TypeDefinitions><SimpleType name="Difference"><Real relativeQuantity="true"/></SimpleType>'
    "</TypeDefinitions>",
    3: '<TypeDefinitions><Float64Type name="Difference" relativeQuantity="true"/>'
    "</TypeDefinitions>",
}


def describe(kind: str, version: int, units: dict[str, str]) -> str:
    """Return modelDescription.xml."""
    depends = {"y": {2: "1", 3: "0"}[version] if kind == "gain" else "", "sum": ""}
    base = "".join(f'<Unit name="{n}"><BaseUnit {b}/></Unit>' for n, b in UNITS.items())
    variables, outputs = [], []
    for reference, (name, kind_, causality, unit, rest) in enumerate(VARIABLES):
        unit = units.get(name, unit)
        variability = "continuous"
        if causality == "parameter":
            variability = "tunable" if name in {"k", "n", "flag"} else "fixed"
        common = (
            f'name="{name}" valueReference="{reference}" causality="{causality}"'
            f' variability="{variability}"'
        )
        typed = f'{rest} unit="{unit.removesuffix(RELATIVE)}"' if unit else rest
        if unit and unit.endswith(RELATIVE):  # said by the variable, or in FMI 3.0 by its type
            typed += ' relativeQuantity="true"' if version == 2 else ' declaredType="Difference"'
        if version == 2:
            variables.append(f"<ScalarVariable {common}><{kind_} {typed}/></ScalarVariable>")
        elif kind_ == "String":
            variables.append(f'<String {common}><Start value=""/></String>')
        else:
            variables.append(f"<{FMI3_TYPES[kind_]} {common} {typed}/>")
        if causality == "output":
            where = f'index="{reference + 1}"' if version == 2 else f'valueReference="{reference}"'
            outputs.append(f'{where} dependencies="{depends[name]}"')
    if version == 3:
        variables.append(
            '<Float64 name="time" valueReference="99" causality="independent"'
            ' variability="continuous"/>'
        )
    if version == 2:
        structure = f"<Outputs>{''.join(f'<Unknown {o}/>' for o in outputs)}</Outputs>"
        root = 'fmiVersion="2.0" guid="' + kind + '"'
    else:
        structure = "".join(f"<Output {o}/>" for o in outputs)
        root = 'fmiVersion="3.0" instantiationToken="' + kind + '"'
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription {root} modelName="{kind}">'
        f'<CoSimulation modelIdentifier="{kind}" canHandleVariableCommunicationStepSize="true"/>'
        f"<UnitDefinitions>{base}</UnitDefinitions>{TYPES[version]}"
        '<DefaultExperiment startTime="0" stopTime="1" stepSize="0.01"/>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def absent(headers: str, model: str) -> str:
    """Return stubs for the functions that are never called but that the standard requires."""
    names = set(re.findall(r"FMI[23]_Export fmi[23]\w+TYPE\s+(\w+);", headers))
    export = (
        "__declspec(dllexport)" if os.name == "nt" else '__attribute__((visibility("default")))'
    )
    missing = sorted(name for name in names if f"{name}(" not in model)
    return "\n".join(f"{export} int {name}(void) {{ return 3; }}" for name in missing)


def library(kind: str) -> Path:
    """Return the compiled model."""
    headers = Path(fmpy.__file__).parent / "c-code"
    files = {f"system/{h.name}": h.read_text() for h in headers.glob("fmi[23]*.h")}
    model = Path(__file__).with_name("model.c").read_text()
    files["model.c"] = model
    files["absent.c"] = absent("".join(files.values()), model)
    number = ["gain", "integrator"].index(kind)
    return toolchain.shared_library(kind, files, flags=(f"-DKIND={number}",))


Make = Callable[..., Path]


@pytest.fixture(scope="session")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """Make an FMU: ``make("gain", 3, u="m")`` is FMI 3.0 with the input in metres."""
    folder = tmp_path_factory.mktemp("fmus")
    made: dict[tuple[object, ...], Path] = {}

    def make(kind: str, version: int = 2, **units: str) -> Path:
        key = (kind, version, *units.items())
        if key not in made:
            platform = toolchain.host_platform()
            place = platform.fmi2 if version == 2 else platform.tuple
            path = folder / str(len(made)) / f"{kind}.fmu"
            path.parent.mkdir()
            with zipfile.ZipFile(path, "w") as archive:
                archive.writestr("modelDescription.xml", describe(kind, version, units))
                binary = library(kind)
                archive.write(binary, f"binaries/{place}/{binary.name}")
            made[key] = path
        return made[key]

    return make


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Let this test unpack into a folder of its own."""
    monkeypatch.setitem(os.environ, "STICKSLIP_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"
