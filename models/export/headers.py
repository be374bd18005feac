"""The C that is generated from model.toml: structs for the model, a table for the adapter."""

from __future__ import annotations

from collections.abc import Sequence
from struct import pack

from stickslip.models.export.description import Model, Role, Variable

_STRUCTS: dict[Role, str] = {
    "input": "Inputs",
    "state": "States",
    "derivative": "Derivatives",
    "indicator": "Indicators",
    "output": "Outputs",
    "memory": "Memory",
    "parameter": "Parameters",
}
_LARGEST = "1.7976931348623157e308"
MARKER = "stickslip start values"
MARKER_SIZE, TOKEN_SIZE = 24, 40  # bytes, with the 0


def variables_header(model: Model) -> str:
    """Return ``variables.h``: a struct of doubles for each role."""
    lines = ["/* Generated from model.toml. */", "#ifndef VARIABLES_H", "#define VARIABLES_H", ""]
    for role, struct in _STRUCTS.items():
        # A derivative goes by the name of its state.
        fields = model.fields.get(role, ())
        if not fields:
            lines += [f"typedef struct {struct} {struct}; /* has no variables */", ""]
            continue
        lines.append("typedef struct {")
        lines += [f"    double {_member(field)};" for field in fields]
        lines += [f"}} {struct};", ""]
    return "\n".join([*lines, *_jacobian(model), *_law(model), "#endif", ""])


def _member(field: tuple[str, tuple[int, ...]]) -> str:
    name, size = field
    return name + "".join(f"[{n}]" for n in size)


def _jacobian(model: Model) -> list[str]:
    """Return the struct of all partial derivatives: a row of states and inputs for each result."""
    if not model.is_continuous or model.is_switched:
        return ["typedef struct Jacobian Jacobian; /* has no derivatives */", ""]
    rows = {role: ", ".join(map(_member, model.fields.get(role, ()))) for role in _STRUCTS}
    return [
        "typedef struct {",
        "    States x;",
        "    Inputs u;",
        "} Gradient;",
        "",
        "typedef struct {",
        "    struct {",
        f"        Gradient {rows['derivative']};",
        "    } dx;",
        "    struct {",
        f"        Gradient {rows['output']};",
        "    } y;",
        "} Jacobian;",
        "",
    ]


def _law(model: Model) -> list[str]:
    """Return what laws/law.h calls a law's parameters, states, derivatives and Jacobian."""
    law = model.law
    if law is None:
        return []
    states = list(law.states)
    lines = [f"#define LAW_IS_SMOOTH {law.is_smooth:d}"]
    lines += [f"#define LAW_SWITCHES {model.is_switched:d}", "typedef Parameters Law;"]
    lines.append(f"typedef {'Memory' if model.sampled else 'States'} LawState;")
    if model.is_switched:
        return [*lines, "typedef Derivatives LawRate;", "typedef Indicators LawEvents;", ""]
    if not law.is_smooth:
        return [*lines, ""]
    columns = ", ".join(["v", *states])
    lines += ["", "typedef struct {"]
    lines += ["    struct {", f"        double {columns};", f"    }} {', '.join(['F', *states])};"]
    lines += ["} LawJacobian;", ""]
    if not model.is_continuous:
        members = [f"    double {name};" for name in states]
        return [*lines, "typedef struct {", *members, "} LawRate;", ""]
    v = "x.v" if any(v.name == "v" and v.role == "state" for v in model.variables) else "u.v"
    rows = {"(*F)": "F"} | {f"J->dx.{name}": name for name in states}
    return [
        *lines,
        "typedef Derivatives LawRate;",
        "",
        "/* Write the law's Jacobian into the rows of the force and of the law's states. */",
        "static inline void law_rows(const LawJacobian *law, Gradient *F, Jacobian *J) {",
        *(
            f"    {row}.{'x.' * (column != 'v')}{v if column == 'v' else column}"
            f" = law->{own}.{column};"
            for row, own in rows.items()
            for column in ("v", *states)
        ),
        "}",
        "",
    ]


def table_header(model: Model) -> str:
    """Return ``table.h``: how many variables there are, and where each role begins."""
    roles = [v.role for v in model.variables]
    numbers = {"COUNT": len(roles)}
    for role, struct in {**_STRUCTS, "mode": "Modes"}.items():
        numbers[f"{struct.upper()}_AT"] = roles.index(role) if role in roles else len(roles)
        numbers[f"{struct.upper()}_COUNT"] = roles.count(role)
    return f"""/* Generated from model.toml. */
#ifndef TABLE_H
#define TABLE_H

#define START_MARKER_SIZE {MARKER_SIZE}
#define START_TOKEN_SIZE {TOKEN_SIZE}

#define IS_CONTINUOUS {model.is_continuous:d}
#define IS_SWITCHED {model.is_switched:d}
#define HAS_SLOPES {model.is_continuous and not model.is_switched:d}
#define IS_SAMPLED {model.sampled:d}

enum {{
{"".join(f"    {name} = {number},{chr(10)}" for name, number in numbers.items())}}};

#endif
"""


def table_source(model: Model) -> str:
    """Return ``table.c``: name, type, phases to set it in, range and nominal of every variable."""
    rows = "".join(f"    {_row(v)}\n" for v in model.variables)
    head = '/* Generated from model.toml. */\n#include "instance.h"\n\n'
    return f"{head}const Variable VARIABLES[COUNT] = {{\n{rows}}};\n"


def start_source(token: str, values: Sequence[float]) -> str:
    """Return ``start.c``: the token, and the start value of every variable (COUNT,)."""
    numbers = "".join(f"    {value!r},\n" for value in map(float, values))
    return (
        '/* Generated from model.toml. */\n#include "instance.h"\n\n'
        f'const Start START = {{"{MARKER}", "{token}", {{\n{numbers}}}}};\n'
    )


def start_bytes(token: str, values: Sequence[float]) -> bytes:
    """Return what a library with ``start.c`` contains behind the marker."""
    return token.encode().ljust(TOKEN_SIZE, b"\0") + pack(f"<{len(values)}d", *values)


def _row(v: Variable) -> str:
    low = f"-{_LARGEST}" if v.minimum is None else repr(float(v.minimum))
    high = _LARGEST if v.maximum is None else repr(float(v.maximum))
    derived = v.role in ("derivative", "indicator", "mode")
    kind = "DERIVATIVE" if derived else v.type.upper()
    nominal = v.nominal or 1.0
    return f'{{"{v.name}", {kind}, {_phases(v)}, {low}, {high}, {nominal!r}}},'


def _phases(v: Variable) -> str:
    before = "INSTANTIATED | INITIALIZATION"
    if v.role == "input":
        return f"{before} | STEPPING | EVENT | CONTINUOUS"
    if v.variability == "tunable":
        return f"{before} | STEPPING | EVENT"
    return before if v.role in ("state", "parameter") else "0"
