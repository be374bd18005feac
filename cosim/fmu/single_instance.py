"""FMUs that can be instantiated once per process only: who has the instance."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import ref

from stickslip.cosim.errors import SimulationError
from stickslip.cosim.fmu.fmu import Fmu

if TYPE_CHECKING:
    from stickslip.cosim.run.prepared import Prepared

# Anywhere here a simulation may be collected, which then gives up what it has, in this very thread.
_lock = threading.RLock()
_holders: dict[tuple[Path, str], ref[Prepared]] = {}


def claim(fmu: Fmu, component: str, simulation: Prepared) -> None:
    """Take the only instance there can be of an FMU; others can be had freely.

    Raises
    ------
    SimulationError
        When another simulation, or another component of this one, has it.
    """
    if not fmu.once_per_process:
        return
    with _lock:
        for (binary, name), holder in _present():
            if binary == fmu.binary and (name, holder) != (component, simulation):
                raise SimulationError(
                    f"{component}: {fmu.path.name} can be instantiated only once per process, and"
                    f" {name} of {holder.spec.system.name} has it; close that simulation first"
                )
        _holders[fmu.binary, component] = ref(simulation)


def give_up(simulation: Prepared) -> None:
    """Give back what a simulation has claimed."""
    with _lock:
        for key, holder in _present():
            if holder is simulation:
                _holders.pop(key, None)


def _present() -> list[tuple[tuple[Path, str], Prepared]]:
    """Return who has what; those that are gone are forgotten."""
    found = []
    for key in list(_holders):
        reference = _holders.get(key)
        holder = reference() if reference else None
        if holder is None:
            _holders.pop(key, None)
        else:
            found.append((key, holder))
    return found
