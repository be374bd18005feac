"""Connections of whole arrays (SSP 2.0) as connections of their elements."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import prod

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.graph import Edge, End, Graph, label
from stickslip.cosim.ssp.markup import place
from stickslip.fmi.description.variables import parse_element

Shape = tuple[int, ...]
MOST_ELEMENTS = 1_000_000

_PARAMETERS = {"parameter", "structuralParameter", "calculatedParameter", "constant"}


def expand(graph: Graph) -> None:
    """Put one connection for each element in the place of those of whole arrays.

    Raises
    ------
    SspError
        When the dimensions of two ends differ, or an element is fed twice.
    """
    signals = [edge for edge in graph.edges.values() if not _is_parameter(graph, edge.target)]
    shapes = [(edge, _shape_at(graph, edge)) for edge in signals]
    for edge, shape in shapes:
        if not shape:
            continue
        if prod(shape) > MOST_ELEMENTS:
            raise SspError(
                f"{place(edge.element)}: cannot connect {label(edge.source)} to"
                f" {label(edge.target)}: {prod(shape)} elements, at most {MOST_ELEMENTS} are"
            )
        graph.drop(edge)
        for place_ in product(*(range(1, n + 1) for n in shape)):
            text = f"[{','.join(map(str, place_))}]"
            source, target = ((path, name + text) for path, name in (edge.source, edge.target))
            graph.put(replace(edge, source=source, target=target))


def _shape_at(graph: Graph, edge: Edge) -> Shape:
    """Return the dimensions of what a connection carries."""
    source, target = (_shape(graph, end, edge, ()) for end in (edge.source, edge.target))
    if source != target:
        raise SspError(
            f"{place(edge.element)}: cannot connect {label(edge.source)} to {label(edge.target)}:"
            f" their dimensions are {source} and {target}"
        )
    return source


def _shape(graph: Graph, end: End, edge: Edge, seen: tuple[End, ...]) -> Shape:
    variable, connector = graph.variable(end), graph.connector(end)
    element = connector is not None and connector.name != end[1]
    declared = connector.dimensions if connector and not element else ()
    if variable:
        wanted = [n for n in declared if n is not None]
        if wanted and declared != variable.dimensions:
            raise SspError(
                f"{place(edge.element)}: the connector {label(end)} has the dimensions {declared},"
                f" its FMU's variable {variable.dimensions}; correct the connector"
            )
        return variable.dimensions
    if element and connector:
        _check_inside(connector.dimensions, end, edge)
    if None not in declared:
        return tuple(n for n in declared if n is not None)
    before = [graph.edges[end].source] if end in graph.edges else []
    for other in (*before, *(e.target for e in graph.onward[end])):
        if other not in seen:
            return _shape(graph, other, edge, (*seen, end))
    raise SspError(f"{place(edge.element)}: nothing says how long the array {label(end)} is")


def _check_inside(dimensions: tuple[int | None, ...], end: End, edge: Edge) -> None:
    parsed = parse_element(end[1])
    indices = parsed[1] if parsed else ()
    if len(indices) != len(dimensions) or any(
        n is not None and i > n for i, n in zip(indices, dimensions, strict=True)
    ):
        raise SspError(
            f"{place(edge.element)}: {label(end)} is no element of an array of the dimensions"
            f" {dimensions}"
        )


def _is_parameter(graph: Graph, end: End) -> bool:
    variable, connector = graph.variable(end), graph.connector(end)
    return (variable.causality if variable else connector and connector.kind) in _PARAMETERS
