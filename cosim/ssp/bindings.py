"""Writes start values of a system that differ from those of its package."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from typing import Any

from lxml import etree

from stickslip.cosim.errors import SspError
from stickslip.cosim.fmu.names import component_of, variable_of
from stickslip.cosim.ssp.compose import add, group, new_root, text_of
from stickslip.cosim.ssp.edit import Editor
from stickslip.cosim.ssp.members import Members, file_name, free_name
from stickslip.cosim.ssp.names import component, path_of, tag
from stickslip.cosim.ssp.parameters import read_parameters
from stickslip.cosim.ssp.values import (
    add_values,
    can_change,
    change,
    file_of,
    parameter_set,
    whole_arrays,
)
from stickslip.cosim.system.system import Origin, System
from stickslip.fmi.description.variables import Value


def edit_parameters(
    editor: Editor, before: System, system: System, members: Members, package: Origin | None
) -> None:
    """Write values where they are written already, else into new bindings.

    Raises
    ------
    SspError
    """
    values = _changed_values(before, system)
    if editor.has_arrays:
        values = whole_arrays(values, system)
    given = read_parameters(editor.graph) if package and values else {}
    uses = Counter(id(element) for _, element in given.values())
    fresh: dict[str, dict[str, Value]] = defaultdict(dict)
    for name, value in values.items():
        element = given[name][1] if name in given else None
        if element is None:
            fresh[component_of(name)][variable_of(name)] = value
        elif not (
            uses[id(element)] == 1
            and can_change(element, value)
            and _change_in_place(editor, given[name], value, members, package)
        ):
            fresh[""][name] = value
    for i, name in enumerate(system.components):
        if name in fresh:
            _bind(editor, system, name, fresh[name], members, file_name(i, name))
    if "" in fresh:
        _bind_on_top(editor, system, fresh[""], members)


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
    editor: Editor,
    given: tuple[Value, Any],
    value: Value,
    members: Members,
    package: Origin | None,
) -> bool:
    """Change a value where it is written, if what is written there is what arrives."""
    arrives, element = given
    text = next(element.iterchildren(tag("ssv:*"))).get("value")
    if str(arrives) != text and not (isinstance(arrives, float) and arrives == float(text)):
        return False
    root, file = element.getroottree(), file_of(element)
    if root.getroot() is editor.document.root:
        change(element, value)
        editor.changed = True
        return True
    if package is None or file is None or not file.is_relative_to(package.folder):
        return False
    member = file.relative_to(package.folder).as_posix()
    if members[member] != file.read_bytes():
        return False  # changed by way of another binding
    change(element, value)
    members[member] = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    return True


def _bind(
    editor: Editor,
    system: System,
    name: str,
    values: Mapping[str, Value],
    members: Members,
    file: str,
) -> None:
    """Bind values to a component."""
    node = editor.graph.nodes[path_of(name)]
    if node.document is not editor.document:
        _bind_on_top(editor, system, {f"{name}.{v}": x for v, x in values.items()}, members)
        return
    version = editor.document.root.get("version")
    source = free_name(f"resources/{file}", ".ssv", members)
    title = component(node.path)
    members[source] = text_of(parameter_set(title, values, name, system, version))
    add(group(node.element, "ssd:ParameterBindings"), "ssd:ParameterBinding", source=source)
    editor.changed = True


def _bind_on_top(
    editor: Editor, system: System, values: Mapping[str, Value], members: Members
) -> None:
    """Bind values to the whole system, where they go before all others."""
    version = editor.document.root.get("version")
    root = new_root("ssv:ParameterSet", "settings", version)
    for name, value in values.items():
        owner = component_of(name)
        prefix = ".".join(path_of(owner)) + "."
        add_values(root, {variable_of(name): value}, owner, system, version, prefix)
    source = free_name("resources/settings", ".ssv", members)
    members[source] = text_of(root)
    body = editor.graph.nodes[()].body
    add(group(body, "ssd:ParameterBindings"), "ssd:ParameterBinding", source=source)
    editor.changed = True
