"""Which components step together because they depend on each other."""

import heapq
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

import numpy as np

from stickslip.cosim.component import component_of, variable_of
from stickslip.cosim.errors import ConnectionFault
from stickslip.cosim.system.settings import Coupling
from stickslip.cosim.system.system import System

Connection = tuple[str, str]  # "component.output", "component.input"


@dataclass(frozen=True)
class Group:
    """Components in the order in which they step, and whether they do so until they agree."""

    components: tuple[str, ...]
    iterated: bool


def group(system: System, coupling: Coupling) -> list[Group]:
    """Return all components in groups, in the order in which they step."""
    names = list(system.components)
    if coupling.method == "jacobi":
        return [Group((name,), iterated=False) for name in names]
    feedthrough = system.feedthrough()
    implicit = coupling.method == "iterative"
    edges = [(s, t) for t, s in system.connections.items()] if implicit else feedthrough
    groups = []
    for members in _sorted_groups(names, edges):
        inner = set(members)
        inside = [(s, t) for s, t in edges if {component_of(s), component_of(t)} <= inner]
        order = [name for g in _sorted_groups(members, _within(feedthrough, inner)) for name in g]
        iterated = bool(inside) and _can_iterate(system, order, implicit=implicit)
        groups.append(Group(tuple(order), iterated))
    return groups


def _can_iterate(system: System, members: Sequence[str], *, implicit: bool) -> bool:
    stuck = [name for name in members if not system.components[name].restores_state]
    if not stuck:
        return True
    loop = algebraic_loop(system, members)
    who = ", ".join(f"{name} ({system.components[name].label})" for name in stuck)
    remedy = f"which {who} cannot: canGetAndSetFMUstate is not declared."
    remedy += " Export it with that, or choose"
    if implicit:
        what = f"repeats the steps of {', '.join(members)}, {remedy} coupling='gauss_seidel'"
        raise ConnectionFault(f"coupling='iterative' {what}")
    if loop:
        raise ConnectionFault(
            f"algebraic loop {' -> '.join(loop)}: every output in it depends on its input without"
            f" delay. To solve it, FMUs must repeat a step, {remedy} coupling='jacobi', which"
            " delays each connection by one step"
        )
    return False


def algebraic_loop(system: System, components: Iterable[str]) -> list[str]:
    """Return the variables of a loop without delay among some components; empty without one."""
    edges = _within(((s, t) for t, s in system.connections.items()), set(components))
    sources: dict[str, list[str]] = {}  # of a variable: those that lead to it
    for source, target in edges:
        sources.setdefault(target, []).append(source)
        component = component_of(target)
        for output, inputs in system.components[component].feedthrough.items():
            if variable_of(target) in inputs:
                sources.setdefault(f"{component}.{output}", []).append(target)
    try:
        TopologicalSorter(sources).prepare()
    except CycleError as fault:
        found: list[str] = fault.args[1][:-1]  # it begins and ends with one of them
        begin = next(found.index(source) for source, _ in edges if source in found)
        return found[begin:] + found[:begin]
    return []


def _within(connections: Iterable[Connection], inner: set[str]) -> list[Connection]:
    return [(s, t) for s, t in connections if component_of(s) in inner and component_of(t) in inner]


def _sorted_groups(names: Sequence[str], edges: Sequence[Connection]) -> list[list[str]]:
    """Return strongly connected components, each after its sources."""
    if len(order := stepping_order(names, edges)) == len(names):  # no loop
        return [[name] for name in order]
    pairs = [(component_of(s), component_of(t)) for s, t in edges]
    groups = {members[0]: members for members in _strongly_connected(names, pairs)}
    first = {name: head for head, members in groups.items() for name in members}
    apart = [(a, b) for a, b in dict.fromkeys(pairs) if first[a] != first[b]]
    between = [(f"{first[a]}.", f"{first[b]}.") for a, b in apart]
    heads = [name for name in names if name in groups]
    return [groups[head] for head in stepping_order(heads, between)]


def stepping_order(components: Sequence[str], feedthrough: Iterable[Connection]) -> list[str]:
    """Sort components so that direct feedthrough is computed before it is read."""
    successors: dict[str, set[str]] = {name: set() for name in components}
    for source, target in feedthrough:
        successors[component_of(source)].add(component_of(target))
    waiting = Counter(b for found in successors.values() for b in found)
    place = {name: i for i, name in enumerate(components)}
    ready = [place[name] for name in components if not waiting[name]]
    order = []
    while ready:
        order.append(components[heapq.heappop(ready)])
        for successor in successors[order[-1]]:
            waiting[successor] -= 1
            if not waiting[successor]:
                heapq.heappush(ready, place[successor])
    return order


def _strongly_connected(nodes: Sequence[str], edges: Sequence[Connection]) -> list[list[str]]:
    """Return the nodes in groups that reach each other, each in the order given."""
    place = {node: i for i, node in enumerate(nodes)}
    rows, columns = [place[a] for a, _ in edges], [place[b] for _, b in edges]
    from scipy.sparse import coo_array  # late: few systems have loops
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(edges)), (rows, columns)), shape=(len(nodes), len(nodes)))
    _, labels = connected_components(graph, directed=True, connection="strong")
    groups: dict[int, list[str]] = {}
    for node, label in zip(nodes, labels, strict=True):
        groups.setdefault(int(label), []).append(node)
    return list(groups.values())
