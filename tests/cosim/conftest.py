"""Small FMUs made on the spot: a gain (direct feedthrough) and an integrator."""

import functools
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.corpus import fmu
from tests.corpus.fmu import Variable

# name, type, causality, unit, start, further attributes; the value reference is the place
VARIABLES = [
    ("u", "Float64", "input", "N", 0, ""),
    ("y", "Float64", "output", "N", None, ""),
    ("k", "Float64", "parameter", None, 1, 'min="-1000" max="1000"'),
    ("fault_time", "Float64", "parameter", "s", 1e9, ""),
    ("sum", "Float64", "output", None, None, ""),
    ("fault", "Int32", "parameter", None, 0, ""),
    ("n", "Int32", "parameter", None, 0, 'min="0" max="9"'),
    ("flag", "Boolean", "parameter", None, "false", ""),
    ("text", "String", "parameter", None, "", ""),
    ("sign", "String", "local", None, None, ""),
]
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
    variables = []
    for name, type_, causality, usual, start, attributes in VARIABLES:
        unit = units.get(name, usual)
        if unit:
            attributes += f' unit="{unit.removesuffix(RELATIVE)}"'
        if unit and unit.endswith(RELATIVE):  # said by the variable, or in FMI 3.0 by its type
            attributes += (
                ' relativeQuantity="true"' if version == 2 else ' declaredType="Difference"'
            )
        varies = "discrete" if type_ == "String" else "continuous"
        if causality == "parameter":
            varies = "tunable" if name in {"k", "n", "flag"} else None
        depends = ["u"] if name == "y" and kind == "gain" else ()
        variables.append(
            Variable(name, causality, start, type_, varies, depends=depends, attributes=attributes)
        )
    base = "".join(f'<Unit name="{n}"><BaseUnit {b}/></Unit>' for n, b in UNITS.items())
    return fmu.describe(
        kind,
        version,
        variables,
        {"CoSimulation": 'canHandleVariableCommunicationStepSize="true"'},
        types=f"<UnitDefinitions>{base}</UnitDefinitions>{TYPES[version]}",
        experiment='startTime="0" stopTime="1" stepSize="0.01"',
    )


def library(name: str, model: int) -> bytes:
    """Return one of the models of models.c, compiled."""
    source = Path(__file__).with_name("models.c")
    return fmu.library(name, source, flags=(f"-DMODEL={model}",)).read_bytes()


Make = Callable[..., Path]


@pytest.fixture(scope="session")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """Make an FMU: ``make("gain", 3, u="m")`` is FMI 3.0 with the input in metres."""
    folder = tmp_path_factory.mktemp("fmus")

    @functools.cache
    def make(kind: str, version: int = 2, **units: str) -> Path:
        model = {"gain": 6, "integrator": 7}[kind]
        files = {fmu.place(kind, version): library(kind, model)}
        path = Path(tempfile.mkdtemp(dir=folder)) / f"{kind}.fmu"
        return fmu.pack(path, describe(kind, version, units), files)

    return make
