"""The C that is generated from model.toml: structs for the model, a table for the adapter."""

from __future__ import annotations

from models.export.description import Model, Role, Variable

_STRUCTS: dict[Role, str] = {
    "input": "Inputs",
    "state": "States",
    "output": "Outputs",
    "memory": "Memory",
    "parameter": "Parameters",
}
_LARGEST = "1.7976931348623157e308"


def variables_header(model: Model) -> str:
    """Return ``variables.h``: a struct of doubles for each role."""
    lines = ["/* Generated from model.toml. */", "#ifndef VARIABLES_H", "#define VARIABLES_H", ""]
    for role, struct in _STRUCTS.items():
        fields = model.fields[role]
        if not fields:
            lines += [f"typedef struct {struct} {struct}; /* has no variables */", ""]
            continue
        lines.append("typedef struct {")
        for name, size in fields:
            lines.append(f"    double {name}{''.join(f'[{n}]' for n in size)};")
        lines += [f"}} {struct};", ""]
    return "\n".join([*lines, "#endif", ""])


def table_header(model: Model, token: str) -> str:
    """Return ``table.h``: how many variables there are, where each role begins, the token."""
    roles = [v.role for v in model.variables]
    begin = {role: roles.index(role) if role in roles else len(roles) for role in _STRUCTS}
    return "\n".join(
        [
            "/* Generated from model.toml. */",
            "#ifndef TABLE_H",
            "#define TABLE_H",
            "",
            f'#define MODEL_NAME "{model.name}"',
            f'#define MODEL_TOKEN "{token}"',
            "",
            "enum {",
            f"    COUNT = {len(roles)},",
            *(f"    {struct.upper()}_AT = {begin[role]}," for role, struct in _STRUCTS.items()),
            "};",
            "",
            "#endif",
            "",
        ]
    )


def table_source(model: Model) -> str:
    """Return ``table.c``: name, type, phases to set it in, start and range of every variable."""
    rows = [f"    {_row(v)}" for v in model.variables]
    return "\n".join(
        [
            "/* Generated from model.toml. */",
            '#include "instance.h"',
            "",
            "const Variable VARIABLES[COUNT] = {",
            *rows,
            "};",
            "",
        ]
    )


def _row(v: Variable) -> str:
    low = f"-{_LARGEST}" if v.minimum is None else repr(float(v.minimum))
    high = _LARGEST if v.maximum is None else repr(float(v.maximum))
    return f'{{"{v.name}", {v.type.upper()}, {_phases(v)}, {v.start!r}, {low}, {high}}},'


def _phases(v: Variable) -> str:
    before = "INSTANTIATED | INITIALIZATION"
    if v.role == "input" or v.variability == "tunable":
        return f"{before} | STEPPING"
    return before if v.role in ("state", "parameter") else "0"
