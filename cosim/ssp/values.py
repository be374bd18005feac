"""Writes start values into a description: where they are given already, or as new bindings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as File
from typing import Any

from stickslip.cosim.errors import SspError
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.ssp.compose import add, add_units, group, new_root
from stickslip.cosim.ssp.markup import local
from stickslip.cosim.ssp.names import tag
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value, Variable

_FLOATS = {"Real", "Float64", "Float32"}
_TYPES = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}


def parameter_set(
    name: str, values: Mapping[str, Value], component: str, system: System, version: str
) -> Any:
    """Return a new ssv:ParameterSet with values of one component, by variable."""
    root = new_root("ssv:ParameterSet", name, version)
    add_values(root, values, component, system, version)
    return root


def add_values(
    root: Any,
    values: Mapping[str, Value],
    component: str,
    system: System,
    version: str,
    prefix: str = "",
) -> None:
    """Put values of one component into an ssv:ParameterSet, in place of those of the same name.

    Raises
    ------
    SspError
        When there is no word for a value in this version.
    """
    parameters = group(root, "ssv:Parameters")
    given = {p.get("name"): p for p in parameters.iterchildren(tag("ssv:Parameter"))}
    for name, value in values.items():
        variable = system.variable(f"{component}.{name}")
        if prefix + name in given:
            parameters.remove(given[prefix + name])
        parameter = add(parameters, "ssv:Parameter", name=prefix + name)
        kind = _type_of(variable, value, version)
        if kind is None:
            raise SspError(
                f"{component}.{name}: SSP {version} has no values that are arrays or binary; write"
                " version='2.0'"
            )
        element = add(parameter, f"ssv:{kind}", value=text_of_value(value))
        for length in variable.dimensions:
            add(parameter, "ssc:Dimension", size=str(length))
        unit = system.components[component].unit(variable)
        if kind in _FLOATS and unit and unit.exponents:
            element.set("unit", unit.name)
            add_units(root, "ssv:Units", [unit])


def text_of_value(value: Value) -> str:
    """Return a value as XML wants it, arrays row by row."""
    if isinstance(value, tuple):
        return " ".join(map(text_of_value, value))
    if isinstance(value, bytes):
        return value.hex()
    return str(value).lower() if isinstance(value, bool) else str(value)


def whole_arrays(values: Mapping[str, Value], system: System) -> dict[str, Value]:
    """Return values in which those of single elements have become those of their arrays.

    Raises
    ------
    SspError
        When the other elements of an array have no value.
    """
    result: dict[str, Value] = {}
    for name, value in values.items():
        variable = system.variable(name)
        if variable.array is None:
            result[name] = value
            continue
        array = f"{component_of(name)}.{variable.array}"
        before = result.get(array, system.parameters.get(array, system.variable(array).start))
        if not isinstance(before, tuple) or isinstance(value, tuple):
            raise SspError(f"{array}: its other elements have no start value; set it as a whole")
        i = variable.element
        result[array] = (*before[:i], value, *before[i + 1 :])
    return result


def change(parameter: Any, value: Value) -> None:
    """Give an ssv:Parameter another value."""
    next(parameter.iterchildren(tag("ssv:*"))).set("value", text_of_value(value))


def can_change(parameter: Any, value: Value) -> bool:
    """Whether an element is an ssv:Parameter of a type that can hold a value."""
    if local(parameter) != "Parameter":
        return False
    kind = local(next(parameter.iterchildren(tag("ssv:*"))))
    return (kind in _FLOATS) == isinstance(value, float) and kind not in {"Enumeration", "Binary"}


def file_of(element: Any) -> File | None:
    """Return the file that an element was read from."""
    url = element.getroottree().docinfo.URL
    return File(url) if url else None


def _type_of(variable: Variable, value: Value, version: str) -> str | None:
    if version != "1.0" and variable.type != "Enumeration":
        return variable.type
    return _TYPES.get(type(value[0] if version != "1.0" and isinstance(value, tuple) else value))
