"""A system as C tables for ``container.c``."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from stickslip.cosim.assembly.plan import Layout
from stickslip.cosim.component import component_of
from stickslip.cosim.container.description import TYPES, ContainerVariable
from stickslip.cosim.errors import ParameterError
from stickslip.cosim.kernel import structures
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value


def system_header(
    system: System,
    run: structures.Run,
    order: Sequence[str],
    layout: Layout,
    shown: Sequence[ContainerVariable],
    folders: Mapping[str, str],
    step: float,
) -> str:
    """Return ``system.h`` without the token; ``run`` is that of ``wire``."""
    parts = [run.components[i] for i in range(len(order))]
    place = {name: i for i, name in enumerate(order)}
    starts = [_start(system, place, *item) for item in system.parameters.items()]
    lines = [
        f"#define STEP {step!r}",
        f"#define JACOBI {int(run.jacobi)}",
        f"#define VARIES_STEP {int(all(c.varies_step for c in system.components.values()))}",
        "typedef struct { int part; Type type; uint32_t reference; double value; } Start;",
        "enum {",
        f"N_PARTS = {len(parts)}, N_INPUTS = {len(system.inputs)}, WIDTH = {max(1, run.width)},",
        f"MOST_INPUTS = {max([1, *(part.n_inputs for part in parts)])},",
        f"N_STARTS = {len(starts)}, N_VARIABLES = {len(shown)} }};",
    ]
    for i, part in enumerate(parts):
        lines += _lists(i, part)
    fmus = [system.components[name] for name in order]
    wired = [
        f"{{{_text(name)}, {_text(fmu.token)}, {_text(folders[name])}, {_text(fmu.binary.stem)},"
        f" {_wiring(i, part)}}}"
        for i, (name, fmu, part) in enumerate(zip(order, fmus, parts, strict=True))
    ]
    return "\n".join(
        [
            *lines,
            _table("Part PARTS", wired),
            _table("Start STARTS", starts or ["{0}"]),
            _table("Variable VARIABLES", [_variable(system, place, layout, v) for v in shown]),
        ]
    )


def _lists(i: int, part: structures.Component) -> list[str]:
    n, outputs = part.n_inputs, part.n_outputs
    lists = [
        ("uint32_t", "read", part.input_references[:n]),
        ("uint32_t", "shown", part.output_references[:outputs]),
        ("int64_t", "from", part.input_offsets[:n] if part.input_offsets else []),
        ("double", "scale", part.scales[: 2 * n] if part.scales else []),
    ]
    return [
        f"static const {kind} {name}{i}[] = {{{', '.join(map(repr, values))}}};"
        for kind, name, values in lists
        if values
    ]


def _wiring(i: int, part: structures.Component) -> str:
    members = {
        "version": part.version,
        "inputs": part.inputs,
        "n_inputs": part.n_inputs,
        "input_references": f"read{i}" if part.n_inputs else "NULL",
        "input_offset": part.input_offset,
        "n_outputs": part.n_outputs,
        "output_references": f"shown{i}" if part.n_outputs else "NULL",
        "column": part.column,
        "input_offsets": f"from{i}" if part.input_offsets else "NULL",
        "scales": f"scale{i}" if part.scales else "NULL",
        "n_linked": part.n_linked,
        "tolerance": repr(part.tolerance),
    }
    return "{" + ", ".join(f".{name} = {value}" for name, value in members.items()) + "}"


def _start(system: System, place: Mapping[str, int], name: str, value: Value) -> str:
    variable = system.variable(name)
    if variable.type not in TYPES or variable.dimensions or variable.array:
        what = f"type {variable.type}{' array' if variable.dimensions or variable.array else ''}"
        advice = "export the component with this value"
        raise ParameterError(f"{name}: a container cannot set a start value of {what}; {advice}")
    number = float(value)  # type: ignore[arg-type]  # of a scalar, by the test above
    part = place[component_of(name)]
    return f"{{{part}, {TYPES[variable.type]}, {variable.reference}, {number!r}}}"


def _variable(
    system: System, place: Mapping[str, int], layout: Layout, v: ContainerVariable
) -> str:
    column = part = reference = 0
    if v.role in {"INPUT", "OUTPUT"}:
        column = layout.columns[v.source]
    elif v.role != "TIME":
        part, reference = place[component_of(v.source)], system.variable(v.source).reference
    start = 0.0 if v.start is None else float(v.start)  # type: ignore[arg-type]
    return f"{{{_text(v.name)}, {v.type}, {v.role}, {part}, {reference}, {column}, {start!r}}}"


def _table(head: str, rows: Sequence[str]) -> str:
    return f"static const {head}[] = {{\n" + ",\n".join(rows) + "};"


def _text(text: str) -> str:
    """Return a string literal of C: that of JSON, with other than ASCII escaped."""
    return "".join(
        c if c.isascii() else "".join(f"\\{byte:03o}" for byte in c.encode())
        for c in json.dumps(text, ensure_ascii=False)
    )
