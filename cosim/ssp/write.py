"""Writes a system as an SSP 1.0 or 2.0 package.

A system that was read from a package is written by changing that package where the system differs
from it, so that geometry, annotations, other variants and files stay as they were.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path as File
from typing import Literal

from lxml import etree

from stickslip.cosim.errors import CosimError, SspError
from stickslip.cosim.fmu.names import component_of, variable_of
from stickslip.cosim.ssp.arrays import expand
from stickslip.cosim.ssp.bindings import edit_parameters
from stickslip.cosim.ssp.compose import add, group, new_root, text_of
from stickslip.cosim.ssp.connectors import Definitions
from stickslip.cosim.ssp.edit import Editor
from stickslip.cosim.ssp.graph import End, Graph
from stickslip.cosim.ssp.members import Members, file_name, free_name, zipped
from stickslip.cosim.ssp.names import ANNOTATION, OSP, STRUCTURE, VERSIONS, path_of, tag
from stickslip.cosim.ssp.read import read_experiment, read_package
from stickslip.cosim.ssp.structure import Document, Node
from stickslip.cosim.ssp.verify import verify
from stickslip.cosim.ssp.version import as_version
from stickslip.cosim.system.scaling import PLAIN, Link
from stickslip.cosim.system.system import System
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.files import atomic_write


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
    editor = Editor(graph, version or document.root.get("version"))
    _edit_components(editor, before, system, members)
    edit_parameters(editor, before, system, members, package)
    _edit_connections(editor, before, system)
    _edit_outside(editor, before, system)
    _edit_times(editor, experiment)
    if editor.changed or not package:
        members[structure] = text_of(document.root)
    if package and version:
        members = as_version(members, version)
    if package and editor.changed:
        verify(members, structure, system)
    return members


def _nothing(system: System, version: str) -> tuple[System, Graph, Members]:
    root = new_root("ssd:SystemStructureDescription", system.name, version)
    body = add(root, "ssd:System", name=system.name)
    document = Document(File(STRUCTURE), File(), root, Definitions.of(root))
    return (
        System(system.name),
        Graph(Node((), document, None, body, document, {}), {}),
        {STRUCTURE: b""},
    )


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
    editor.changed = True


def _end(name: str) -> End:
    return path_of(component_of(name)), variable_of(name)
