"""What a coupling remembers from one step to the next, as arrays that can be saved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.ctypeslib import as_array

from stickslip.cosim.kernel.structures import MAX_PAST
from stickslip.cosim.signals.signals import Array

_COUNTS = ("n_past", "steps", "sweeps", "rejected", "inner")


def memory_of_coupling(table: Any, width: int, *, disturbed: bool) -> dict[str, Array]:
    """Return copies of the past points, the Jacobians and the counts of a ``kernel.Coupling``.

    Parameters
    ----------
    width : number of signals
    disturbed : whether a scenario changes some
    """
    memory = {name: place.copy() for name, place in _places(table, width).items()}
    if not disturbed:  # what is given is what is received
        memory["given"] = np.append(memory["past"][:width], memory["next"])
    memory["counts"] = np.array([getattr(table, name) for name in _COUNTS])
    memory["known"] = np.array([table.loops[i].known for i in range(table.n_loops)])
    return memory


def recall(table: Any, width: int, memory: Mapping[str, Array]) -> None:
    """Write what ``memory_of_coupling`` returned back.

    Raises
    ------
    KeyError, ValueError
        When it belongs to another coupling.
    """
    for name, place in _places(table, width).items():
        if memory[name].shape != place.shape:
            raise ValueError(f"{memory[name].shape} {name}, expected {place.shape}")
        place[:] = memory[name]
    counts = dict(zip(_COUNTS, memory["counts"], strict=True))
    step = counts["inner"]
    if not (0 <= counts["n_past"] <= MAX_PAST and 0 <= step < np.inf):
        raise ValueError(f"{counts['n_past']} past points and a step of {step} s")
    if len(memory["known"]) != table.n_loops:
        raise ValueError(f"{len(memory['known'])} loops, expected {table.n_loops}")
    for name, value in counts.items():
        setattr(table, name, float(value) if name == "inner" else int(value))
    for i, known in enumerate(memory["known"]):
        table.loops[i].known = int(known)


def _places(table: Any, width: int) -> dict[str, Array]:
    """Return the kernel's own memory, by name."""
    rooms = {"past": (table.past, MAX_PAST * width), "next": (table.next, width)}
    rooms["given"] = (table.given, 2 * width)
    loops = (table.loops[i] for i in range(table.n_loops))
    rooms |= {f"inverse{i}": (loop.inverse, loop.n**2) for i, loop in enumerate(loops)}
    places = {name: as_array(room, (n,)) for name, (room, n) in rooms.items() if n}
    return places | {"times": as_array(table.times)}
