"""Writes start values of a system that differ from those of its package."""

from collections import Counter, defaultdict
from collections.abc import Mapping
from pathlib import Path as File
from typing import Any

from lxml import etree

from stickslip.cosim.component import component_of, variable_of
from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.edit import Editor
from stickslip.cosim.ssp.markup import (
    Members,
    add,
    add_units,
    file_name,
    free_name,
    group,
    local,
    new_root,
    path_of,
    tag,
    text_of,
)
from stickslip.cosim.ssp.read import read_parameters
from stickslip.cosim.system.system import Origin, System
from stickslip.fmi.description.variables import Value, Variable

_FLOATS = {"Real", "Float64", "Float32"}
_TYPES = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}


def edit_parameters(
    editor: Editor, before: System, system: System, members: Members, package: Origin | None
) -> None:
    """Write values where they are written already, else into new bindings."""
    values = _changed_values(before, system)
    if editor.has_arrays:
        values = _whole_arrays(values, system)
    given = read_parameters(editor.graph) if package and values else {}
    uses = Counter(id(element) for _, element in given.values())
    fresh: dict[str, dict[str, Value]] = defaultdict(dict)  # by component; on top by no name
    for name, value in values.items():
        element, owner = given[name][1] if name in given else None, component_of(name)
        inside = editor.graph.nodes[path_of(owner)].document is editor.document
        if element is None:
            fresh[owner if inside else ""][name] = value
        elif not (
            uses[id(element)] == 1
            and _can_change(element, value)
            and _change_in_place(editor, given[name], value, members, package)
        ):
            fresh[""][name] = value
    for i, name in enumerate(system.components):
        if name in fresh:
            _bind(editor, system, fresh[name], members, file_name(i, name), name)
    if "" in fresh:
        _bind(editor, system, fresh[""], members, "settings")


def _changed_values(before: System, system: System) -> dict[str, Value]:
    values = {n: v for n, v in system.parameters.items() if before.parameters.get(n) != v}
    for name in before.parameters.keys() - system.parameters.keys():
        if component_of(name) not in system.components:
            continue
        start = system.variable(name).start
        if start is None:
            raise SspError(f"{name} has no start value in its FMU to go back to")
        values[name] = start
    return values


def _change_in_place(
    editor: Editor, given: tuple[Value, Any], value: Value, members: Members, package: Origin | None
) -> bool:
    """Change a value where it is written, if no mapping or scaling changes it on the way."""
    arrives, element = given
    written = next(element.iterchildren(tag("ssv:*")))
    text = written.get("value")
    if str(arrives) != text and not (isinstance(arrives, float) and arrives == float(text)):
        return False
    root = element.getroottree()
    if root.getroot() is editor.document.root:
        written.set("value", _text_of_value(value))
        return True
    file = File(root.docinfo.URL or "/")
    if package is None or not file.is_relative_to(package.folder):
        return False
    member = file.relative_to(package.folder).as_posix()
    if members[member] != file.read_bytes():
        return False  # changed through another binding
    written.set("value", _text_of_value(value))
    members[member] = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    return True


def _bind(
    editor: Editor,
    system: System,
    values: Mapping[str, Value],
    members: Members,
    stem: str,
    component: str = "",
) -> None:
    """Bind values to a component, or to the whole system, where they go before all others."""
    version, whole = editor.document.root.get("version"), not component
    # One name for all components: ecos applies the parameter set of a name to all that have it.
    root = new_root("ssv:ParameterSet", "settings" if whole else "parameters", version)
    parameters = group(root, "ssv:Parameters")
    for name, value in values.items():
        owner, variable = component_of(name), system.variable(name)
        prefix = ".".join(path_of(owner)) + "." if whole else ""
        parameter = add(parameters, "ssv:Parameter", name=prefix + variable_of(name))
        kind = _type_of(variable, value, version)
        if kind is None:
            raise SspError(
                f"{name}: SSP {version} has no values that are arrays or binary; write"
                " version='2.0'"
            )
        element = add(parameter, f"ssv:{kind}", value=_text_of_value(value))
        for length in variable.dimensions:
            add(parameter, "ssc:Dimension", size=str(length))
        unit = system.components[owner].unit(variable)
        if kind in _FLOATS and unit and unit.exponents:
            element.set("unit", unit.name)
            add_units(root, "ssv:Units", [unit])
    source = free_name(f"resources/{stem}", ".ssv", members)
    members[source] = text_of(root)
    node = editor.graph.nodes[path_of(component) if component else ()]
    bindings = group(node.body if whole else node.element, "ssd:ParameterBindings")
    add(bindings, "ssd:ParameterBinding", source=source)


def _text_of_value(value: Value) -> str:
    """Return a value as XML wants it, arrays row by row."""
    if isinstance(value, tuple):
        return " ".join(map(_text_of_value, value))
    if isinstance(value, bytes):
        return value.hex()
    return str(value).lower() if isinstance(value, bool) else str(value)


def _whole_arrays(values: Mapping[str, Value], system: System) -> dict[str, Value]:
    """Return values in which those of single elements have become those of their arrays."""
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


def _can_change(parameter: Any, value: Value) -> bool:
    """Whether an element is an ssv:Parameter of a type that can hold a value."""
    if local(parameter) != "Parameter":
        return False
    kind = local(next(parameter.iterchildren(tag("ssv:*"))))
    return (kind in _FLOATS) == isinstance(value, float) and kind not in {"Enumeration", "Binary"}


def _type_of(variable: Variable, value: Value, version: str) -> str | None:
    if version != "1.0" and variable.type != "Enumeration":
        return variable.type
    return _TYPES.get(type(value[0] if version != "1.0" and isinstance(value, tuple) else value))
