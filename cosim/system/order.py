"""In which order components step."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence

from stickslip.cosim.errors import ConnectionFault
from stickslip.cosim.fmu.names import component_of

Connection = tuple[str, str]  # "component.output", "component.input"


def stepping_order(components: Sequence[str], feedthrough: Iterable[Connection]) -> list[str]:
    """Sort components so that each direct feedthrough is computed before it is read.

    Parameters
    ----------
    components : names; ties keep this order
    feedthrough : the connections whose output depends on an input of its component without delay

    Raises
    ------
    ConnectionFault
        When there is no such order: an algebraic loop, named.
    """
    successors: dict[str, dict[str, Connection]] = {name: {} for name in components}
    waiting = dict.fromkeys(components, 0)
    for source, target in feedthrough:
        a, b = component_of(source), component_of(target)
        if b not in successors[a]:
            successors[a][b] = (source, target)
            waiting[b] += 1
    place = {name: i for i, name in enumerate(components)}
    ready = [place[name] for name in components if not waiting[name]]
    order = []
    while ready:
        name = components[heapq.heappop(ready)]
        order.append(name)
        for successor in successors[name]:
            waiting[successor] -= 1
            if not waiting[successor]:
                heapq.heappush(ready, place[successor])
    if len(order) < len(components):
        loop = _find_loop(successors, set(components) - set(order))
        raise ConnectionFault(
            f"algebraic loop {loop}: every output in it depends on its input without delay;"
            " choose coupling='jacobi', which delays each connection by one step"
        )
    return order


def _find_loop(successors: dict[str, dict[str, Connection]], stuck: set[str]) -> str:
    predecessors = {b: a for a in stuck for b in successors[a] if b in stuck}
    name = next(iter(sorted(stuck)))
    seen: list[str] = []
    while name not in seen:
        seen.append(name)
        name = predecessors[name]
    backwards = [*seen[seen.index(name) :], name]
    pairs = zip(backwards[:0:-1], backwards[-2::-1], strict=True)
    return " -> ".join(end for a, b in pairs for end in successors[a][b])
