"""The C of a model as functions and types of structured text (IEC 61131-3).

Structs become STRUCTs and what a pointer points to VAR_IN_OUT. A conditional expression becomes IF
before the statement that it is in. exp, log and sin are those of the controller.
"""

from __future__ import annotations

from stickslip.models.firmware.program import ROLES, Program
from stickslip.models.firmware.statements import Statements

_EXP = """(* e^x without overflow and underflow *)
FUNCTION {prefix}_exp : LREAL
VAR_INPUT
    x : LREAL;
END_VAR
    IF x < -700.0 THEN
        {prefix}_exp := 0.0;
    ELSIF x > 700.0 THEN
        {prefix}_exp := EXP(700.0);
    ELSE
        {prefix}_exp := EXP(x);
    END_IF;
END_FUNCTION
"""


def translated(program: Program) -> str:
    """Return TYPEs and FUNCTIONs, callees first."""
    functions = [
        Statements(program, variant).text()
        for name in reversed(program.functions)
        for variant in program.variants.get(name, {}).values()
    ]
    own = [name for name in program.fields if name not in ROLES]
    types = [_struct(program, name) for name in (*ROLES, *own) if program.fields[name]]
    return "\n".join(
        [*program.arrays.values(), *types, _EXP.format(prefix=program.prefix), *reversed(functions)]
    )


def _struct(program: Program, name: str) -> str:
    members = program.fields[name].values()
    lines = [program.declaration(one, program.member(name, one.name)) for one in members]
    head = f"TYPE {program.type_name(name)} :"
    return "\n".join([head, "STRUCT", *lines, "END_STRUCT;", "END_TYPE", ""])
