"""FMUs as other tools export them, made on the spot from tests/cosim/models.c."""

import functools
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.corpus import fmu
from tests.corpus.fmu import Variable
from tests.cosim.conftest import library

NUMERIC = ["Float64", "Float32"]
NUMERIC += [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
NUMERIC += ["Boolean", "Enumeration"]


def _row(
    name: str,
    reference: int,
    type_: str,
    causality: str,
    variability: str,
    start: object = None,
    **more: Any,
) -> Variable:
    return Variable(name, causality, start, type_, variability, reference=reference, **more)


def _feedthrough() -> list[Variable]:
    variables = []
    for i, kind in enumerate([*NUMERIC, "Float64"]):
        last = i == len(NUMERIC)
        variability = "continuous" if kind.startswith("Float") and not last else "discrete"
        start = {"Boolean": "false", "Enumeration": "1"}.get(kind, "0")
        name = "discrete" if last else kind
        option = 'declaredType="Option"' if kind == "Enumeration" else ""
        variables += [
            _row(f"{name}_in", i, kind, "input", variability, start, attributes=option),
            _row(f"{name}_out", 30 + i, kind, "output", variability, attributes=option),
        ]
    variables += [
        _row("sum", 100, "Float64", "output", "continuous"),
        _row("s", 101, "String", "parameter", "fixed", ""),
        _row("bytes", 102, "Binary", "parameter", "fixed", ""),
        _row("big", 103, "Int64", "parameter", "fixed", "0"),
        _row("told", 105, "Float64", "output", "continuous"),
    ]
    return variables


def _clocked() -> list[Variable]:
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
            _row(name, i, "Clock", "input", "discrete", attributes=attributes),
            _row(f"{name}_ticks", 10 + i, "Int32", "output", "discrete"),
            _row(f"{name}_at", 15 + i, "Float64", "output", "discrete"),
        ]
    triggered = clocks["by_hand"]
    variables += [_row("tock", 20, "Clock", "output", "discrete", attributes=triggered)]
    return variables


OF_N = 'valueReference="0"'
ALIAS = '<Alias name="height of the ball"/>'
MODELS = {
    "feedthrough": _feedthrough(),
    "state_space": [
        _row("n", 0, "UInt64", "structuralParameter", "fixed", "3"),
        _row(
            "A",
            1,
            "Float64",
            "parameter",
            "tunable",
            "-1 0 0 0 -1 0 0 0 -1",
            dimensions=[OF_N, OF_N],
        ),
        _row("u", 65, "Float64", "input", "continuous", "0 0 0", dimensions=[OF_N]),
        _row("y", 73, "Float64", "output", "continuous", None, dimensions=[OF_N]),
        _row("x0", 81, "Float64", "parameter", "fixed", "0 0 0", dimensions=[OF_N]),
    ],
    "ball": [
        _row("h", 0, "Float64", "local", "continuous", "1", initial="exact"),
        _row("v", 1, "Float64", "local", "continuous", "0", initial="exact"),
        _row("der(h)", 10, "Float64", "local", "continuous", derivative="h"),
        _row("der(v)", 11, "Float64", "local", "continuous", derivative="v"),
        _row("g", 2, "Float64", "parameter", "fixed", "-9.81"),
        _row("e", 3, "Float64", "parameter", "tunable", "0.7"),
        _row("bounces", 4, "Int32", "output", "discrete"),
        _row("height", 5, "Float64", "output", "continuous", inside=ALIAS),
    ],
    "oscillator": [
        _row("position", 0, "Float64", "output", "continuous", "1", initial="exact"),
        _row("velocity", 1, "Float64", "output", "continuous", "0", initial="exact"),
        _row("der(position)", 10, "Float64", "local", "continuous", derivative="position"),
        _row("der(velocity)", 11, "Float64", "local", "continuous", derivative="velocity"),
        _row("k", 2, "Float64", "parameter", "fixed", "4"),
        _row("force", 3, "Float64", "input", "continuous", "0"),
        _row("gain", 4, "Float64", "output", "continuous"),
        _row("events", 5, "Int32", "output", "discrete"),
    ],
    "stair": [
        _row("count", 0, "Int32", "output", "discrete"),
        _row("period", 1, "Float64", "parameter", "fixed", "0.25"),
        _row("last", 2, "Int32", "parameter", "fixed", "1000"),
        _row("trigger", 3, "Boolean", "input", "discrete", "false"),
        _row("level", 5, "Int32", "output", "discrete"),
    ],
    "clocked": _clocked(),
}


def describe(
    model: str, version: int, interfaces: str, flags: str = "", experiment: str = ""
) -> str:
    """Return modelDescription.xml."""
    varies = f' canHandleVariableCommunicationStepSize="{str("fixed" not in interfaces).lower()}"'
    events = ' hasEventMode="true"' if version == 3 and "events" in interfaces else ""
    kinds = {"ModelExchange": "", "CoSimulation": varies + events, "ScheduledExecution": ""}
    chosen = zip(("ME", "CS", "SE"), kinds.items(), strict=True)
    items = "".join(f'<Item name="{n}" value="{i}"/>' for i, n in enumerate("abc", 1))
    option = (
        f'<SimpleType name="Option"><Enumeration>{items}</Enumeration></SimpleType>'
        if version == 2
        else f'<EnumerationType name="Option">{items}</EnumerationType>'
    )
    ball = model == "ball"
    return fmu.describe(
        model,
        version,
        MODELS[model],
        {kind: flags + more for short, (kind, more) in chosen if short in interfaces},
        head=f'numberOfEventIndicators="{ball:d}"' if version == 2 else "",
        types=f"<TypeDefinitions>{option}</TypeDefinitions>",
        experiment=experiment,
        structure='<EventIndicator valueReference="0"/>' if ball else "",
    )


Export = Callable[..., Path]


@pytest.fixture(scope="session")
def export(tmp_path_factory: pytest.TempPathFactory) -> Export:
    """Export an FMU: ``export("ball", 3, "ME CS events")``."""
    folder = tmp_path_factory.mktemp("any fmu")

    @functools.cache
    def export(
        model: str,
        version: int,
        interfaces: str = "ME CS",
        flags: str = "",
        binary_name: str | None = None,
        experiment: str = "",
    ) -> Path:
        description = describe(model, version, interfaces, flags, experiment)
        binary = library(model, list(MODELS).index(model))
        files = {fmu.place(binary_name or model, version): binary}
        return fmu.pack(Path(tempfile.mkdtemp(dir=folder)) / f"{model}.fmu", description, files)

    return export
