"""Writes a system as an SSP 1.0 or 2.0 package.

A system that was read from a package is written by changing that package where the system differs
from it, so that geometry, annotations, other variants and files stay as they were.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path as File
from typing import Literal

from lxml import etree

from stickslip.cosim.component import component_of, variable_of
from stickslip.cosim.errors import CosimError, SspError
from stickslip.cosim.ssp.bindings import edit_parameters
from stickslip.cosim.ssp.connectors import Definitions
from stickslip.cosim.ssp.edit import Editor
from stickslip.cosim.ssp.graph import End, Graph, expand
from stickslip.cosim.ssp.markup import (
    ANNOTATION,
    NAMESPACES,
    OSP,
    ROOTS,
    STRUCTURE,
    VERSIONS,
    Members,
    add,
    file_name,
    free_name,
    group,
    new_root,
    path_of,
    short,
    tag,
    text_of,
    violation,
)
from stickslip.cosim.ssp.read import read_experiment, read_package
from stickslip.cosim.ssp.structure import Document, Node, Package
from stickslip.cosim.system.scaling import PLAIN, Link, Scaling
from stickslip.cosim.system.system import System
from stickslip.fmi.archive import zipped
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.variables import Value
from stickslip.fmi.files import atomic_write
from stickslip.fmi.process import temporary_folder
from stickslip.fmi.xml import Malformed, parse_xml

_WHOLE = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
_OLD_NAMES = {"Float64": "Real", "Float32": "Real", **dict.fromkeys(_WHOLE, "Integer")}


def write_ssp(
    system: System,
    path: str | os.PathLike[str],
    experiment: DefaultExperiment | None = None,
    *,
    version: Literal["1.0", "2.0"] | None = None,
) -> File:
    """Write a system with its FMUs, start values, units and times; return the path.

    Connectors are written for all outputs and for the connected inputs, since some tools require a
    source for each connector. Components called ``outer/inner`` are written into nested systems.

    Parameters
    ----------
    system : to write
    path : of the ``.ssp`` file
    experiment : the times it proposes; of a system that was read, those of its package by default
    version : of SSP; of a system that was read, that of its package by default, else 1.0

    Raises
    ------
    SspError : when an FMU is no longer where it was read from, a nested system that lies in a file
        of its own would have to be changed, or the version cannot express the package
    OSError : when the file cannot be written
    """
    if version not in {None, *VERSIONS}:
        raise SspError(f"version is {version!r}, expected '1.0' or '2.0'")
    try:
        members = _members(system, experiment, version)
    except CosimError as fault:
        raise SspError(f"{path}: {fault}") from fault
    except OSError as fault:
        raise SspError(f"{path}: cannot pack {fault.filename}: {fault.strerror}") from fault
    return atomic_write(File(path), zipped(members))


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
    graph.lengths = {path_of(name): system.lengths(name) for name in system.components}
    unchanged = etree.tostring(document.root)
    editor = Editor(graph, version or document.root.get("version"))
    _edit_components(editor, before, system, members)
    edit_parameters(editor, before, system, members, package)
    _edit_connections(editor, before, system)
    _edit_outside(editor, before, system)
    _edit_times(editor, experiment)
    changed = etree.tostring(document.root) != unchanged
    if changed or not package:
        members[structure] = text_of(document.root)
    if package and version:
        members = {name: _converted(name, data, version) for name, data in members.items()}
    if package and changed:
        _verify(members, structure, system)
    return members


def _nothing(system: System, version: str) -> tuple[System, Graph, Members]:
    root = new_root("ssd:SystemStructureDescription", system.name, version)
    body = add(root, "ssd:System", name=system.name)
    document = Document(File(STRUCTURE), File(), root, Definitions.of(root))
    graph = Graph(Node((), document, None, body, document, {}), {})
    return System(system.name), graph, {STRUCTURE: b""}


def _edit_components(editor: Editor, before: System, system: System, members: Members) -> None:
    for name in before.components.keys() - system.components.keys():
        editor.remove(path_of(name))
    for i, (name, fmu) in enumerate(system.fmus("an SSP").items()):
        known = before.fmus("an SSP").get(name)
        if known and known.path == fmu.path:
            continue
        source = free_name(f"resources/{file_name(i, name)}", ".fmu", members)
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
    missing = {t: s for t, s in new.items() if _end(t) not in editor.graph.edges}
    for target, source in missing.items():
        end = _end(target)
        if end in editor.graph.edges:
            continue  # with the rest of its array
        if editor.has_arrays and (whole := _whole(system, missing, target)):
            editor.connect(_end(whole[0]), _end(whole[1]))
            expand(editor.graph)
            continue
        if source in system.inputs:
            editor.expose(source, "input", end, system.unit_of(source))
        start: End = ((), source) if source in system.inputs else _end(source)
        try:
            editor.connect(start, end, _written_out(system, source, target))
        except SspError as fault:
            raise SspError(f"{source} to {target}: {fault}") from None


def _whole(system: System, sources: Mapping[str, str], target: str) -> tuple[str, str] | None:
    """Return source and target as arrays, where all their elements are connected as they are."""
    names = [sources[target], target]
    if names[0] in system.inputs:
        return None
    owners = [system.variable(name).array for name in names]
    if None in owners:
        return None
    arrays = [f"{component_of(name)}.{owner}" for name, owner in zip(names, owners, strict=True)]
    starts, ends = (
        [f"{component_of(array)}.{v.name}" for v in system.variable(array).elements()]
        for array in arrays
    )
    pairs = dict(zip(ends, starts, strict=False))
    plain = len(starts) == len(ends) and not pairs.keys() & system.links.keys()
    return (arrays[0], arrays[1]) if plain and pairs.items() <= sources.items() else None


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


def _end(name: str) -> End:
    return path_of(component_of(name)), variable_of(name)


def _converted(name: str, data: bytes, version: str) -> bytes:
    """Return a member of a package in a version of SSP; those of that version stay untouched."""
    part = name.rpartition(".")[2]
    if part not in ROOTS:
        return data
    try:
        root = parse_xml(data, remarks=True)
    except Malformed as fault:
        raise SspError(f"{name}: {fault}") from fault
    roots = [element for kind in ROOTS.values() for element in root.iter(tag(kind))]
    if all(element.get("version") == version for element in roots):
        return data
    for element in roots:
        element.set("version", version)
    if version == "1.0":
        for prefix in ("ssc", "ssv"):
            for new, old in _OLD_NAMES.items():
                for element in root.iter(f"{{{NAMESPACES[prefix]}}}{new}"):
                    element.tag = f"{{{NAMESPACES[prefix]}}}{old}"
    if breach := violation(root, part, version):
        raise SspError(
            f"{name}, line {breach[0]}: SSP {version} cannot express this: {short(breach[1])}"
        )
    text: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    return text


def _verify(members: Members, structure: str, system: System) -> None:
    """Read a changed package back; a binding may still name a component that was removed."""
    with temporary_folder() as folder:
        for member, data in members.items():
            file = folder / member
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)
        try:
            again = read_package(Package(folder / structure, folder, structure))[0]
        except CosimError as fault:
            raise SspError(f"the changed package would be broken: {fault}") from fault
    names = system.parameters
    wanted, found = _meaning(system, names), _meaning(again, names)
    for part, value in wanted.items():
        if not _same(found[part], value):
            raise SspError(f"the changed package would have {part} {found[part]}, not {value}")


def _meaning(system: System, parameters: Iterable[str]) -> dict[str, object]:
    scalings = {
        f"the scaling of {target}": system.scaling(source, target)
        for target, source in system.sources().items()
    }
    starts = {f"the start value of {name}": _start_value(system, name) for name in parameters}
    parts = {f"the {part}": getattr(system, part) for part in ("connections", "inputs", "outputs")}
    return {**parts, **scalings, **starts}


def _same(one: object, other: object) -> bool:
    if not (isinstance(one, Scaling) and isinstance(other, Scaling)):
        return one == other
    factors, offsets = (one.factor, other.factor), (one.offset, other.offset)
    return math.isclose(*factors, rel_tol=1e-12) and math.isclose(
        *offsets, rel_tol=1e-12, abs_tol=1e-300
    )


def _start_value(system: System, name: str) -> Value | None:
    """Return a start value; of an element it may be that in its array."""
    variable = system.variable(name)
    whole = system.parameters.get(f"{component_of(name)}.{variable.array}")
    inside = whole[variable.element] if isinstance(whole, tuple) else None
    return system.parameters.get(name, inside)
