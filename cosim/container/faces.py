"""The functions of a standard that a container does not offer, but must have: they refuse."""

from __future__ import annotations

import re

_PROTOTYPE = re.compile(r"typedef\s+(?P<result>\w+)\s+(?P<name>fmi\w+)TYPE\s*\((?P<rest>.*?)\);")
_PARAMETER = re.compile(r"(\w+)\s*(\[\])?$")


def refusals(header: str, face: str, version: int) -> str:
    """Return C for all functions of the standard that ``face`` does not define.

    Parameters
    ----------
    header : text of ``fmi2FunctionTypes.h`` or ``fmi3FunctionTypes.h``
    face : text of ``fmi2.c`` or ``fmi3.c``
    """
    plain = " ".join(re.sub(r"/\*.*?\*/", " ", header, flags=re.DOTALL).split())
    present = set(re.findall(rf"fmi{version}\w+(?=\()", face))
    for kind in re.findall(r"^ACCESS\((\w+),", face, re.MULTILINE):
        present |= {f"fmi{version}Get{kind}", f"fmi{version}Set{kind}"}
    status = f"fmi{version}Status"
    functions = [
        _refusal(found, status)
        for found in _PROTOTYPE.finditer(plain)
        if found["result"] == status and found["name"] not in present
    ]
    head = [f"#include <fmi{version}Functions.h>", '#include "container.h"']
    return "\n".join([*head, *functions, ""])


def _refusal(found: re.Match[str], status: str) -> str:
    names = [_PARAMETER.search(part.strip()) for part in found["rest"].split(",")]
    instance, *others = [match[1] for match in names if match]
    unused = "".join(f"(void){name};" for name in others)
    answer = f"{instance} ? ({status})container_refuse({instance}, __func__) : ({status})ERROR"
    return f"{status} {found['name']}({found['rest']}) {{ {unused} return {answer}; }}"
