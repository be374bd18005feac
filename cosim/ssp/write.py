"""Writes a system as an SSP 1.0 or 2.0 package.

A system that was read from a package is written by changing that package where the system differs
from it, so that geometry, annotations, other variants and files stay as they were.
"""

from __future__ import annotations

import io
import os
import re
import zipfile
from collections import Counter, defaultdict
from collections.abc import Mapping
from pathlib import Path as File
from typing import Any, Literal

from lxml import etree

import toolchain
from cosim.errors import CosimError, SspError
from cosim.experiment import DefaultExperiment
from cosim.names import component_of, variable_of
from cosim.scaling import PLAIN, Link
from cosim.ssp.compose import add, group, new_root, text_of
from cosim.ssp.edit import Editor
from cosim.ssp.graph import End, Graph
from cosim.ssp.names import ANNOTATION, OSP, STRUCTURE, VERSIONS, component, path_of, tag
from cosim.ssp.package import Package
from cosim.ssp.parameters import read_parameters
from cosim.ssp.read import read_experiment, read_package
from cosim.ssp.structure import Document, Node
from cosim.ssp.values import add_values, can_change, change, file_of, parameter_set
from cosim.ssp.version import as_version
from cosim.system import System
from cosim.variables import Value

_TIMESTAMP = (1980, 1, 1, 0, 0, 0)  # the same system gives the same bytes

Members = dict[str, bytes]


def write_ssp(
    system: System,
    path: str | os.PathLike[str],
    experiment: DefaultExperiment | None = None,
    *,
    version: Literal["1.0", "2.0"] | None = None,
) -> File:
    """Write a system with its FMUs, start values, units and times; return the path.

    Connectors are written for all outputs and for the inputs that are fed: a tool that wants a
    source for each connector finds one. Components called ``outer/inner`` come into nested
    systems.

    Parameters
    ----------
    system : to write
    path : of the ``.ssp`` file
    experiment : the times it proposes; of a system that was read, those of its package by default
    version : of SSP; of a system that was read, that of its package by default, else 1.0

    Raises
    ------
    SspError
        When an FMU is no longer where it was read from, a nested system that lies in a file of its
        own would have to be changed, or the package holds what the version cannot say.
    OSError
        When the file cannot be written.
    """
    if version not in {None, *VERSIONS}:
        raise SspError(f"version is {version!r}, expected '1.0' or '2.0'")
    try:
        members = _members(system, experiment, version)
    except CosimError as fault:
        raise SspError(f"{path}: {fault}") from fault
    except OSError as fault:
        raise SspError(f"{path}: cannot pack {fault.filename}: {fault.strerror}") from fault
    return toolchain.write_whole(File(path), _zip(members))


def _members(system: System, experiment: DefaultExperiment | None, version: str | None) -> Members:
    package = system.origin
    if package is None:
        before, graph, members = _nothing(system, version or "1.0")
    else:
        before, _, graph = read_package(package)
        members = {
            file.relative_to(package.folder).as_posix(): file.read_bytes()
            for file in sorted(package.folder.rglob("*"))
            if file.is_file()
        }
    structure = package.structure if package else STRUCTURE
    document = graph.nodes[()].document
    editor = Editor(graph, version or document.root.get("version"))
    _edit_components(editor, before, system, members)
    _edit_parameters(editor, before, system, members, package)
    _edit_connections(editor, before, system)
    _edit_outside(editor, before, system)
    _edit_times(editor, experiment)
    if editor.changed or not package:
        members[structure] = text_of(document.root)
    return as_version(members, version) if version and package else members


def _nothing(system: System, version: str) -> tuple[System, Graph, Members]:
    root = new_root("ssd:SystemStructureDescription", system.name, version)
    body = add(root, "ssd:System", name=system.name)
    document = Document(File(STRUCTURE), File(), root, {})
    return (
        System(system.name),
        Graph(Node((), document, None, body, document, {}), {}),
        {STRUCTURE: b""},
    )


def _edit_components(editor: Editor, before: System, system: System, members: Members) -> None:
    for name in before.components.keys() - system.components.keys():
        editor.remove(path_of(name))
    for i, (name, fmu) in enumerate(system.components.items()):
        known = before.components.get(name)
        if known and known.path == fmu.path:
            continue
        source = _free(f"resources/{_file_name(i, name)}", ".fmu", members)
        members[source] = fmu.path.read_bytes()
        if known and known.folder != fmu.folder:
            editor.replace(path_of(name), source)
        elif not known:
            editor.add(path_of(name), fmu, source)


def _edit_connections(editor: Editor, before: System, system: System) -> None:
    old, new = before.sources(), system.sources()
    for target, source in old.items():
        end = _end(target)
        same = new.get(target) == source and before.links.get(target) == system.links.get(target)
        if not same and end in editor.graph.edges:
            editor.disconnect(end)
    for target, source in new.items():
        end = _end(target)
        if end in editor.graph.edges:
            continue
        if source in system.inputs:
            editor.expose(source, "input", end, system.unit_of(source))
        start: End = ((), source) if source in system.inputs else _end(source)
        editor.connect(start, end, _written_out(system, source, target))


def _written_out(system: System, source: str, target: str) -> Link:
    """Return a link that says the conversion of units too, for tools that convert none."""
    link, total = system.links.get(target, PLAIN), system.scaling(source, target)
    return link if total == link.scaling else Link(total, convert=False)


def _edit_outside(editor: Editor, before: System, system: System) -> None:
    for name in before.inputs.keys() - system.inputs.keys():
        editor.conceal(name)
    for name, source in before.outputs.items():
        if system.outputs.get(name) != source:
            editor.conceal(name)
    for name, source in system.outputs.items():
        if before.outputs.get(name) != source:
            editor.expose(name, "output", _end(source), system.unit_of(source))
            editor.connect(_end(source), ((), name))


def _edit_parameters(
    editor: Editor, before: System, system: System, members: Members, package: Package | None
) -> None:
    values = _changed_values(before, system)
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
            _bind(editor, system, name, fresh[name], members, _file_name(i, name))
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
    package: Package | None,
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
    source = _free(f"resources/{file}", ".ssv", members)
    title = component(node.path)
    members[source] = text_of(parameter_set(title, values, system.components[name], version))
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
        add_values(root, {variable_of(name): value}, system.components[owner], version, prefix)
    source = _free("resources/settings", ".ssv", members)
    members[source] = text_of(root)
    body = editor.graph.nodes[()].body
    add(group(body, "ssd:ParameterBindings"), "ssd:ParameterBinding", source=source)
    editor.changed = True


def _edit_times(editor: Editor, experiment: DefaultExperiment | None) -> None:
    root = editor.document.root
    before = read_experiment(root)
    if experiment is None or experiment == before:
        return
    element = group(root, "ssd:DefaultExperiment")
    for name, time in (("startTime", experiment.start), ("stopTime", experiment.stop)):
        element.attrib.pop(name, None)
        if time is not None:
            element.set(name, repr(float(time)))
    if experiment.step != before.step:
        annotations = group(element, "ssd:Annotations")
        for annotation in annotations.findall(f"{tag('ssc:Annotation')}[@type='{ANNOTATION}']"):
            annotations.remove(annotation)
        if experiment.step is not None:
            annotation = add(annotations, "ssc:Annotation", type=ANNOTATION)
            algorithm = etree.SubElement(annotation, f"{{{OSP}}}Algorithm")
            fixed = etree.SubElement(algorithm, f"{{{OSP}}}FixedStepAlgorithm")
            fixed.set("baseStepSize", repr(float(experiment.step)))
        elif not len(annotations):
            element.remove(annotations)
    editor.changed = True


def _end(name: str) -> End:
    return path_of(component_of(name)), variable_of(name)


def _file_name(i: int, name: str) -> str:
    return re.sub(r"[^\w-]", "_", f"{i}_{name}", flags=re.ASCII)


def _free(stem: str, suffix: str, members: Members) -> str:
    """Return a member name that is not taken."""
    name, n = stem + suffix, 1
    while name in members:
        n += 1
        name = f"{stem}_{n}{suffix}"
    return name


def _zip(members: Members) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in sorted(members.items()):
            member = zipfile.ZipInfo(name, _TIMESTAMP)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.create_system = 3
            member.external_attr = 0o644 << 16
            archive.writestr(member, content)
    return buffer.getvalue()
