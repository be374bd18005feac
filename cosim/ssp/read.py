"""Reads an SSP 1.0 or 2.0 package as a system without nesting."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from cosim.errors import CosimError, SspError
from cosim.experiment import DefaultExperiment
from cosim.fmu import Fmu
from cosim.scaling import Link
from cosim.ssp.graph import End, Graph
from cosim.ssp.markup import number, place
from cosim.ssp.names import ANNOTATION, NAMESPACES, OSP, Path, component
from cosim.ssp.package import Package
from cosim.ssp.parameters import read_parameters
from cosim.ssp.structure import read_structure
from cosim.system import System


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
        When the file is no SSP package, or holds what cannot be run: components that are no FMUs,
        mappings of Boolean, Integer or Enumeration signals, parameters that are arrays.
    """
    package = Package.open(path, variant)
    try:
        return read_package(package)[:2]
    except CosimError as fault:
        raise SspError(f"{package.path}: {fault}") from fault


def read_package(package: Package) -> tuple[System, DefaultExperiment, Graph]:
    """Read a system, the times it proposes and the graph that it was laid flat from.

    Raises
    ------
    CosimError
    """
    top = read_structure(package.folder / package.structure, package.folder)
    system = System(top.body.get("name") or "system")
    fmus: dict[Path, Fmu] = {}
    for node in top.walk():
        if node.fmu is not None:
            with _blaming(node.element):
                system.add(component(node.path), node.fmu)
            fmus[node.path] = system.components[component(node.path)]
    graph = Graph(top, fmus)
    _connect(system, graph)
    _show_outputs(system, graph)
    for name, (value, element) in read_parameters(graph).items():
        with _blaming(element):
            system.set(name, value)
    system.origin = package
    return system, read_experiment(top.document.root), graph


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
    return DefaultExperiment(
        _time(element, "startTime"),
        _time(element, "stopTime"),
        None if step is None else _time(step, "baseStepSize"),
    )


def _connect(system: System, graph: Graph) -> None:
    exposed: dict[str, dict[str, Link]] = defaultdict(dict)
    for target in [end for end in graph.edges if graph.is_component(end)]:
        way = graph.way_to(target)
        source, name = way[0].source, _label(target)
        kind = system.variable(name).causality
        if kind != "input":
            if graph.is_component(source):
                raise SspError(
                    f"{place(way[-1].element)}: {_label(source)} cannot feed {name}: it is a {kind}"
                )
            continue  # a parameter that a binding sets through a connector
        link = graph.link(way)
        with _blaming(way[-1].element):
            if graph.is_component(source):
                system.connect(_label(source), name, link)
            elif source[0] == ():
                exposed[source[1]][name] = link
    for name, links in exposed.items():
        connector = graph.nodes[()].connectors[name]
        with _blaming(graph.onward[(), name][0].element):
            system.expose(name, *links, unit=_other(connector.unit, links, system), links=links)


def _other(unit: Any, links: Mapping[str, Link], system: System) -> Any:
    """Return the unit of a connector where it is not that of its first target."""
    first = system.unit_of(next(iter(links)))
    return None if unit is None or (first and unit.same_as(first)) else unit


def _show_outputs(system: System, graph: Graph) -> None:
    for name, connector in graph.nodes[()].connectors.items():
        if connector.kind == "output":
            way = graph.way_to(((), name))
            if way and graph.is_component(way[0].source):
                with _blaming(way[-1].element):
                    system.expose_output(name, _label(way[0].source))


def _label(end: End) -> str:
    return f"{component(end[0])}.{end[1]}"


def _time(element: Any, name: str) -> float | None:
    return None if element.get(name) is None else number(element, name, 0.0)


@contextmanager
def _blaming(element: Any) -> Iterator[None]:
    """Let errors name the line that they come from."""
    try:
        yield
    except CosimError as fault:
        raise SspError(f"{place(element)}: {fault}") from fault
