"""A system as C tables for ``container.c``."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Mapping, Sequence

from stickslip.cosim.assembly.general_path import GeneralComponent
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
    general: Mapping[str, GeneralComponent],
    order: Sequence[str],
    layout: Layout,
    shown: Sequence[ContainerVariable],
    folders: Mapping[str, str],
    step: float,
) -> str:
    """Return ``system.h`` without the token; ``run`` and ``general`` are those of ``wire``."""
    parts = [run.components[i] for i in range(len(order))]
    place = {name: i for i, name in enumerate(order)}
    starts = [_start(system, place, *item) for item in system.parameters.items()]
    lines = [
        f"#define STEP {step!r}",
        f"#define JACOBI {int(run.jacobi)}",
        f"#define VARIES_STEP {int(all(c.varies_step for c in system.components.values()))}",
        f"#define GENERAL {int(bool(general))}",
        f"#define EXCHANGE {int(any(found.c.model_exchange for found in general.values()))}",
        "typedef struct { int part; Type type; uint32_t reference; double value; } Start;",
        "enum {",
        f"N_PARTS = {len(parts)}, N_INPUTS = {len(system.inputs)}, WIDTH = {max(1, run.width)},",
        f"MOST_INPUTS = {max([1, *(part.n_inputs for part in parts)])},",
        f"N_STARTS = {len(starts)}, N_VARIABLES = {len(shown)} }};",
    ]
    for i, part in enumerate(parts):
        lines += _lists(i, part)
        if found := general.get(order[i]):
            lines += _general(i, found.c, part, run, step)
    fmus = [system.components[name] for name in order]
    coupled = {component_of(target) for target in system.connections}
    wired = [
        f"{{{_text(name)}, {_text(fmu.token)}, {_text(folders[name])}, {_text(fmu.binary.stem)},"
        f" {_wiring(i, part)}, {f'&general{i}' if name in general else 'NULL'},"
        f" {int(name in coupled)}}}"
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
    return _struct(members)


def _general(
    i: int,
    c: structures.GeneralComponent,
    part: structures.Component,
    run: structures.Run,
    step: float,
) -> list[str]:
    """Return what a component on the general path begins with; the rest is made when it runs."""
    lines = []
    offsets = part.input_offsets or range(part.input_offset, part.input_offset + c.n_inputs)
    for port, offset in zip(c.input_ports[: c.n_inputs], offsets[: c.n_inputs], strict=True):
        if offset % run.width < run.n_external:
            port.ahead = False  # what the importing tool sets holds for the whole step
    for side, groups in (("taken", c.inputs), ("given", c.outputs)):
        entries = []
        for k in range(groups.n):
            g, name = groups.groups[k], f"{side}{i}_{k}"
            stored = list(structures.STORED.values())[g.stored]
            values = ctypes.cast(g.values, ctypes.POINTER(stored))[: g.n_values]
            lines += [
                f"static const uint32_t {name}[] = {{{', '.join(map(str, g.references[: g.n]))}}};",
                f"static double {name}_values[] = {{{', '.join(repr(float(v)) for v in values)}}};",
            ]
            members = {"name": _text(g.name.decode()), "references": name}
            members |= {k: getattr(g, k) for k in ("stored", "discrete", "clock", "n", "n_values")}
            entries.append(_struct(members | {"values": f"{name}_values"}))
        lines.append(f"static Group {side}{i}[] = {{{', '.join(entries) or '{0}'}}};")
    for side, ports, n in (
        ("taken", c.input_ports, c.n_inputs),
        ("given", c.output_ports, part.n_outputs),
    ):
        rows = [f"{{{p.group}, {p.place}, {p.ahead}}}" for p in ports[:n]]
        lines.append(f"static const Port {side}{i}_ports[] = {{{', '.join(rows) or '{0}'}}};")
    fields = ("reference", "asked", "interval", "shift")
    clocks = [_struct({k: getattr(clock, k) for k in fields}) for clock in c.clocks[: c.n_clocks]]
    lines.append(f"static Clock clocks{i}[] = {{{', '.join(clocks) or '{0}'}}};")
    members = {
        "version": c.version,
        "model_exchange": c.model_exchange,
        "event_mode": c.event_mode,
        "notes_steps": c.notes_steps,
        "inputs": f"{{{c.inputs.n}, taken{i}}}",
        "outputs": f"{{{c.outputs.n}, given{i}}}",
        "input_ports": f"taken{i}_ports",
        "output_ports": f"given{i}_ports",
        "n_inputs": c.n_inputs,
        "tolerance": repr(c.tolerance),
        "n_states": c.n_states,
        "n_indicators": c.n_indicators,
        "near": repr(1e-6 * step),
        "n_clocks": c.n_clocks,
        "clocks": f"clocks{i}",
    }
    return [*lines, f"static const GeneralComponent general{i} = {_struct(members)};"]


def _start(system: System, place: Mapping[str, int], name: str, value: Value) -> str:
    variable = system.variable(name)
    if variable.type not in TYPES or variable.dimensions or variable.array:
        raise ParameterError(
            f"{name}: a container cannot set a start value of type {variable.type}"
            f"{' array' if variable.dimensions or variable.array else ''};"
            " export the component with this value"
        )
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


def _struct(members: Mapping[str, object]) -> str:
    return "{" + ", ".join(f".{name} = {value}" for name, value in members.items()) + "}"


def _table(head: str, rows: Sequence[str]) -> str:
    return f"static const {head}[] = {{\n" + ",\n".join(rows) + "};"


def _text(text: str) -> str:
    """Return a string literal of C: that of JSON, with other than ASCII escaped."""
    return "".join(
        c if c.isascii() else "".join(f"\\{byte:03o}" for byte in c.encode())
        for c in json.dumps(text, ensure_ascii=False)
    )
