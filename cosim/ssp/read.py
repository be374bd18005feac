"""Reads an SSP 1.0 or 2.0 package as a system without nesting."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from stickslip.cosim.errors import CosimError, SspError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.names import component_of, variable_of
from stickslip.cosim.ssp.graph import Graph, expand, label
from stickslip.cosim.ssp.markup import number, place
from stickslip.cosim.ssp.names import ANNOTATION, NAMESPACES, OSP, Path, component
from stickslip.cosim.ssp.package import Package
from stickslip.cosim.ssp.parameters import read_parameters
from stickslip.cosim.ssp.structure import read_structure
from stickslip.cosim.system.scaling import Link
from stickslip.cosim.system.system import Origin, System
from stickslip.fmi.description.model import DefaultExperiment


def read_ssp(
    path: str | os.PathLike[str], variant: str | None = None
) -> tuple[System, DefaultExperiment]:
    """Read a system and the times it proposes.

    Components of nested systems are called ``outer/inner``, so that their variables are
    ``outer/inner.variable``. The system remembers the package: written again, it keeps all that is
    not read of it.

    Parameters
    ----------
    path : the ``.ssp`` file
    variant : name of one of ``variants(path)``, or of its file; the default one if left out

    Raises
    ------
    SspError
        When the file is not an SSP package, or a component is not an FMU.
    """
    package = Package.open(path, variant)
    try:
        return read_package(package)[:2]
    except CosimError as fault:
        raise SspError(f"{package.path}: {fault}") from fault


def read_package(package: Origin) -> tuple[System, DefaultExperiment, Graph]:
    """Read a system, its default experiment and the graph that it was flattened from."""
    top = read_structure(package.folder / package.structure, package.folder)
    system = System(top.body.get("name") or "system")
    fmus: dict[Path, Fmu] = {}
    for node in top.walk():
        if node.fmu is not None:
            with _blaming(node.element):
                system.add(component(node.path), node.fmu)
            fmus[node.path] = system.fmus("an SSP")[component(node.path)]
    graph = Graph(top, fmus)
    for name, (value, element) in _structure_first(read_parameters(graph), system):
        with _blaming(element):
            system.set(name, value)
    graph.lengths = {path: system.lengths(component(path)) for path in fmus}
    expand(graph)
    _connect(system, graph)
    _show_outputs(system, graph)
    system.origin = package
    return system, read_experiment(top.document.root), graph


def _structure_first(given: Mapping[str, Any], system: System) -> list[tuple[str, Any]]:
    """Return start values, those ahead that say how long arrays are."""

    def is_other(item: tuple[str, Any]) -> bool:
        name = item[0]
        return variable_of(name) not in system.components[component_of(name)].structural

    return sorted(given.items(), key=is_other)


def read_experiment(root: Any) -> DefaultExperiment:
    """Return the times that a SystemStructureDescription proposes."""
    element = root.find("ssd:DefaultExperiment", NAMESPACES)
    if element is None:
        return DefaultExperiment()
    step = element.find(
        f"ssd:Annotations/ssc:Annotation[@type='{ANNOTATION}']"
        f"/{{{OSP}}}Algorithm/{{{OSP}}}FixedStepAlgorithm",
        NAMESPACES,
    )
    times = DefaultExperiment(
        _time(element, "startTime"),
        _time(element, "stopTime"),
        None if step is None else _time(step, "baseStepSize"),
    )
    if times.stop is not None and times.stop <= (times.start or 0.0):
        raise SspError(
            f"{place(element)}: stopTime is {times.stop} s, expected a time after startTime ="
            f" {times.start or 0.0} s"
        )
    if times.step is not None and times.step <= 0:
        raise SspError(f"{place(step)}: baseStepSize is {times.step} s, expected a positive one")
    return times


def _connect(system: System, graph: Graph) -> None:
    exposed: dict[str, dict[str, Link]] = defaultdict(dict)
    for target in [end for end in graph.edges if graph.is_component(end)]:
        way = graph.way_to(target)
        source, name = way[0].source, label(target)
        kind = system.variable(name).causality
        if kind != "input":
            if graph.is_component(source):
                ends = f"{label(source)} to {name}"
                raise SspError(f"{place(way[-1].element)}: cannot connect {ends}: it is a {kind}")
            continue  # a parameter that a binding sets through a connector
        link = graph.link(way)
        with _blaming(way[-1].element):
            if graph.is_component(source):
                system.connect(label(source), name, link)
            elif source[0] == ():
                exposed[source[1]][name] = link
    for name, links in exposed.items():
        with _blaming(graph.onward[(), name][0].element):
            unit = _other(graph.unit(((), name)), links, system)
            system.expose(name, *links, unit=unit, links=links)


def _other(unit: Any, links: Mapping[str, Link], system: System) -> Any:
    """Return the unit of a connector where it is not that of its first target."""
    first = system.unit_of(next(iter(links)))
    return None if unit is None or (first and unit.same_as(first)) else unit


def _show_outputs(system: System, graph: Graph) -> None:
    for path, name in [end for end in graph.edges if end[0] == ()]:
        way, connector = graph.way_to((path, name)), graph.connector((path, name))
        if connector and connector.kind == "output" and graph.is_component(way[0].source):
            with _blaming(way[-1].element):
                system.expose_output(name, label(way[0].source))


def _time(element: Any, name: str) -> float | None:
    return None if element.get(name) is None else number(element, name, 0.0)


@contextmanager
def _blaming(element: Any) -> Iterator[None]:
    """Add file and line of an element to errors."""
    try:
        yield
    except CosimError as fault:
        raise SspError(f"{place(element)}: {fault}") from fault
