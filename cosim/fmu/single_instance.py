"""FMUs that can be instantiated once per process only: who has the instance."""

from __future__ import annotations

import threading
from pathlib import Path
from weakref import ref

from stickslip.cosim.component import Component
from stickslip.cosim.errors import SimulationError

# Anywhere here a simulation may be collected, which then gives up what it has, in this very thread.
_lock = threading.RLock()
_holders: dict[tuple[Path, str], tuple[ref[object], str]] = {}


def claim(fmu: Component, component: str, simulation: object, system: str) -> None:
    """Reserve the only instance of an FMU that allows one per process.

    Parameters
    ----------
    simulation : that has the component
    system : its name
    """
    if not fmu.once_per_process:
        return
    with _lock:
        for (binary, name), holder, owner in _present():
            if binary == fmu.binary and (name, holder) != (component, simulation):
                raise SimulationError(
                    f"{component}: {fmu.label} can be instantiated only once per process, and"
                    f" {name} of {owner} has it; close that simulation first"
                )
        _holders[fmu.binary, component] = ref(simulation), system


def release(simulation: object) -> None:
    """Give back what a simulation has claimed."""
    with _lock:
        for key, holder, _ in _present():
            if holder is simulation:
                _holders.pop(key, None)


def _present() -> list[tuple[tuple[Path, str], object, str]]:
    """Return the reserved instances with their simulations and the names of the systems."""
    found = []
    for key, (reference, system) in list(_holders.items()):
        holder = reference()
        if holder is None:
            _holders.pop(key, None)
        else:
            found.append((key, holder, system))
    return found
