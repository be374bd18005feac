"""Writes start values into a description: where they are given already, or as new bindings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as File
from typing import Any

from cosim.fmu import Fmu
from cosim.ssp.compose import add, add_units, group, new_root
from cosim.ssp.markup import local
from cosim.ssp.names import tag
from cosim.variables import Value

_TYPES = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}


def parameter_set(
    name: str, values: Mapping[str, Value], fmu: Fmu, version: str, prefix: str = ""
) -> Any:
    """Return a new ssv:ParameterSet with values of one component, by variable."""
    root = new_root("ssv:ParameterSet", name, version)
    add_values(root, values, fmu, version, prefix)
    return root


def add_values(
    root: Any, values: Mapping[str, Value], fmu: Fmu, version: str, prefix: str = ""
) -> None:
    """Put values of one component into an ssv:ParameterSet, in place of those of the same name."""
    parameters = group(root, "ssv:Parameters")
    given = {p.get("name"): p for p in parameters.iterchildren(tag("ssv:Parameter"))}
    for variable, value in values.items():
        name = prefix + variable
        if name in given:
            parameters.remove(given[name])
        parameter = add(parameters, "ssv:Parameter", name=name)
        kind = _type_of(fmu, variable, value, version)
        element = add(parameter, f"ssv:{kind}", value=text_of_value(value))
        unit = fmu.unit(fmu.variables[variable])
        if isinstance(value, float) and unit and unit.exponents:
            element.set("unit", unit.name)
            add_units(root, "ssv:Units", [unit])


def text_of_value(value: Value) -> str:
    """Return a value as XML wants it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def change(parameter: Any, value: Value) -> None:
    """Give an ssv:Parameter another value."""
    next(parameter.iterchildren(tag("ssv:*"))).set("value", text_of_value(value))


def can_change(parameter: Any, value: Value) -> bool:
    """Whether an element is an ssv:Parameter of a type that can hold a value."""
    if local(parameter) != "Parameter":
        return False
    kind = local(next(parameter.iterchildren(tag("ssv:*"))))
    return (kind in {"Real", "Float64", "Float32"}) == isinstance(value, float) and (
        kind != "Enumeration"
    )


def file_of(element: Any) -> File | None:
    """Return the file that an element was read from."""
    url = element.getroottree().docinfo.URL
    return File(url) if url else None


def _type_of(fmu: Fmu, variable: str, value: Value, version: str) -> str:
    kind = fmu.variables[variable].type
    return kind if version != "1.0" and kind not in {"Enumeration"} else _TYPES[type(value)]
