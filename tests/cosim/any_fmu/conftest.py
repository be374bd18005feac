"""FMUs as other tools export them, made on the spot from models.c."""

from __future__ import annotations

import os
import re
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import fmpy
import pytest

from stickslip.fmi import toolchain

FMI2_TYPES = {
    "Float64": "Real",
    "Int32": "Integer",
    "Boolean": "Boolean",
    "Enumeration": "Enumeration",
    "String": "String",
}
NUMERIC = ["Float64", "Float32"]
NUMERIC += [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
NUMERIC += ["Boolean", "Enumeration"]


@dataclass(frozen=True)
class Var:
    name: str
    reference: int
    type: str
    causality: str
    variability: str
    start: str | None = None
    dimensions: tuple[str, ...] = ()  # valueReference="0" or start="3"
    derivative: int | None = None  # value reference of the state
    initial: str | None = None
    clock: str = ""  # attributes of a clock


def _feedthrough() -> list[Var]:
    variables = []
    for i, kind in enumerate([*NUMERIC, "Float64"]):
        last = i == len(NUMERIC)
        variability = "continuous" if kind.startswith("Float") and not last else "discrete"
        start = {"Boolean": "false", "Enumeration": "1"}.get(kind, "0")
        name = "discrete" if last else kind
        variables += [
            Var(f"{name}_in", i, kind, "input", variability, start),
            Var(f"{name}_out", 30 + i, kind, "output", variability),
        ]
    variables += [
        Var("sum", 100, "Float64", "output", "continuous"),
        Var("s", 101, "String", "parameter", "fixed", ""),
        Var("bytes", 102, "Binary", "parameter", "fixed", ""),
        Var("big", 103, "Int64", "parameter", "fixed", "0"),
        Var("told", 105, "Float64", "output", "continuous"),
    ]
    return variables


def _clocked() -> list[Var]:
    clocks = {
        "every": 'intervalVariability="constant" intervalDecimal="0.25" shiftDecimal="0.125"',
        "growing": 'intervalVariability="changing"',
        "after": 'intervalVariability="countdown"',
        "by_hand": 'intervalVariability="triggered"',
        "asked": 'intervalVariability="calculated"',
    }
    variables = []
    for i, (name, attributes) in enumerate(clocks.items()):
        variables += [
            Var(name, i, "Clock", "input", "discrete", clock=attributes),
            Var(f"{name}_ticks", 10 + i, "Int32", "output", "discrete"),
            Var(f"{name}_at", 15 + i, "Float64", "output", "discrete"),
        ]
    return variables


MODELS = {
    "feedthrough": _feedthrough(),
    "state_space": [
        Var("n", 0, "UInt64", "structuralParameter", "fixed", "3"),
        Var("A", 1, "Float64", "parameter", "tunable", "-1 0 0 0 -1 0 0 0 -1", ("0", "0")),
        Var("u", 65, "Float64", "input", "continuous", "0 0 0", ("0",)),
        Var("y", 73, "Float64", "output", "continuous", None, ("0",)),
        Var("x0", 81, "Float64", "parameter", "fixed", "0 0 0", ("0",)),
    ],
    "ball": [
        Var("h", 0, "Float64", "local", "continuous", "1", initial="exact"),
        Var("v", 1, "Float64", "local", "continuous", "0", initial="exact"),
        Var("der(h)", 10, "Float64", "local", "continuous", derivative=0),
        Var("der(v)", 11, "Float64", "local", "continuous", derivative=1),
        Var("g", 2, "Float64", "parameter", "fixed", "-9.81"),
        Var("e", 3, "Float64", "parameter", "tunable", "0.7"),
        Var("bounces", 4, "Int32", "output", "discrete"),
        Var("height", 5, "Float64", "output", "continuous"),
    ],
    "oscillator": [
        Var("position", 0, "Float64", "output", "continuous", "1", initial="exact"),
        Var("velocity", 1, "Float64", "output", "continuous", "0", initial="exact"),
        Var("der(position)", 10, "Float64", "local", "continuous", derivative=0),
        Var("der(velocity)", 11, "Float64", "local", "continuous", derivative=1),
        Var("k", 2, "Float64", "parameter", "fixed", "4"),
        Var("force", 3, "Float64", "input", "continuous", "0"),
        Var("gain", 4, "Float64", "output", "continuous"),
        Var("events", 5, "Int32", "output", "discrete"),
    ],
    "stair": [
        Var("count", 0, "Int32", "output", "discrete"),
        Var("period", 1, "Float64", "parameter", "fixed", "0.25"),
        Var("last", 2, "Int32", "parameter", "fixed", "1000"),
        Var("trigger", 3, "Boolean", "input", "discrete", "false"),
        Var("level", 5, "Int32", "output", "discrete"),
    ],
    "clocked": _clocked(),
}


def _variable(v: Var, version: int, index: dict[int, int]) -> str:
    common = (
        f'name="{v.name}" valueReference="{v.reference}" causality="{v.causality}"'
        f' variability="{v.variability}"' + (f' initial="{v.initial}"' if v.initial else "")
    )
    typed = ""
    if v.start is not None and v.type not in {"String", "Binary"}:
        typed += f' start="{v.start}"'
    if v.type == "Enumeration":
        typed += ' declaredType="Option"'
    if v.derivative is not None:
        typed += f' derivative="{index[v.derivative] if version == 2 else v.derivative}"'
    typed += f" {v.clock}"
    if version == 2:
        start = ' start=""' if v.type == "String" else ""
        return f"<ScalarVariable {common}><{FMI2_TYPES[v.type]}{typed}{start}/></ScalarVariable>"
    inner = "".join(f'<Dimension valueReference="{d}"/>' for d in v.dimensions)
    inner += '<Start value=""/>' if v.type in {"String", "Binary"} else ""
    inner += '<Alias name="height of the ball"/>' if v.name == "height" else ""
    return f"<{v.type} {common}{typed}>{inner}</{v.type}>"


def describe(
    model: str, version: int, interfaces: str, flags: str = "", experiment: str = ""
) -> str:
    """Return modelDescription.xml."""
    variables = [v for v in MODELS[model] if version == 3 or v.type in FMI2_TYPES]
    index = {v.reference: i for i, v in enumerate(variables, 1)}
    events = ' hasEventMode="true"' if version == 3 and "events" in interfaces else ""
    identity = f'modelIdentifier="{model}" {flags}'
    kinds = f"<ModelExchange {identity}/>" if "ME" in interfaces else ""
    if "CS" in interfaces:
        varies = str("fixed" not in interfaces).lower()
        kinds += (
            f'<CoSimulation {identity}{events} canHandleVariableCommunicationStepSize="{varies}"/>'
        )
    if "SE" in interfaces:
        kinds += f"<ScheduledExecution {identity}/>"
    items = "".join(f'<Item name="{n}" value="{i}"/>' for i, n in enumerate("abc", 1))
    option = (
        f'<SimpleType name="Option"><Enumeration>{items}</Enumeration></SimpleType>'
        if version == 2
        else f'<EnumerationType name="Option">{items}</EnumerationType>'
    )
    text = "".join(_variable(v, version, index) for v in variables)
    rates = [v for v in variables if v.derivative is not None]
    outputs = [v for v in variables if v.causality == "output"]
    if version == 2:
        groups = {"Outputs": outputs, "Derivatives": rates}
        structure = "".join(
            f"<{g}>" + "".join(f'<Unknown index="{index[v.reference]}"/>' for v in m) + f"</{g}>"
            for g, m in groups.items()
            if m
        )
        root = f'fmiVersion="2.0" guid="{model}" numberOfEventIndicators="{int(model == "ball")}"'
    else:
        text += (
            '<Float64 name="time" valueReference="999" causality="independent"'
            ' variability="continuous"/>'
        )
        groups = {"Output": outputs, "ContinuousStateDerivative": rates}
        structure = "".join(
            f'<{g} valueReference="{v.reference}"/>' for g, m in groups.items() for v in m
        )
        if model == "ball":
            structure += '<EventIndicator valueReference="0"/>'
        root = f'fmiVersion="3.0" instantiationToken="{model}"'
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription {root} modelName="{model}">'
        f"{kinds}<TypeDefinitions>{option}</TypeDefinitions><DefaultExperiment {experiment}/>"
        f"<ModelVariables>{text}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def library(model: str) -> Path:
    """Return the compiled model; functions that the standard requires and nobody calls fail."""
    headers = Path(fmpy.__file__).parent / "c-code"
    files = {f"system/{h.name}": h.read_text() for h in headers.glob("fmi[23]*.h")}
    source = Path(__file__).with_name("models.c").read_text()
    names = set(re.findall(r"FMI[23]_Export fmi[23]\w+TYPE\s+(\w+);", "".join(files.values())))
    made = re.compile(r"ACCESS3?\((?:(fmi2), )?(\w+),")
    present = {
        f"{v or 'fmi3'}{verb}{n}" for v, n in made.findall(source) for verb in ("Get", "Set")
    }
    export = (
        "__declspec(dllexport)" if os.name == "nt" else '__attribute__((visibility("default")))'
    )
    missing = sorted(n for n in names - present if not re.search(rf"[ *]{n}\(", source))
    files["models.c"] = source
    files["absent.c"] = "\n".join(f"{export} int {n}(void) {{ return 3; }}" for n in missing)
    number = list(MODELS).index(model)
    return toolchain.shared_library(model, files, flags=(f"-DMODEL={number}",))


Export = Callable[..., Path]


@pytest.fixture(scope="session")
def export(tmp_path_factory: pytest.TempPathFactory) -> Export:
    """Export an FMU: ``export("ball", 3, "ME CS events")``."""
    folder = tmp_path_factory.mktemp("any fmu")
    made: dict[tuple[object, ...], Path] = {}

    def export(
        model: str,
        version: int,
        interfaces: str = "ME CS",
        flags: str = "",
        binary_name: str | None = None,
        platform_folder: str | None = None,
        experiment: str = "",
    ) -> Path:
        key = (model, version, interfaces, flags, binary_name, platform_folder, experiment)
        if key not in made:
            platform = toolchain.host_platform()
            place = platform_folder or (platform.fmi2 if version == 2 else platform.tuple)
            path = folder / str(len(made)) / f"{model}.fmu"
            path.parent.mkdir()
            binary = library(model)
            name = (binary_name or model) + platform.suffix
            with zipfile.ZipFile(path, "w") as archive:
                description = describe(model, version, interfaces, flags, experiment)
                archive.writestr("modelDescription.xml", description)
                archive.write(binary, f"binaries/{place}/{name}")
            made[key] = path
        return made[key]

    return export
