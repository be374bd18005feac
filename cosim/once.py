"""FMUs that can be instantiated once per process only: who has the instance."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakValueDictionary

from cosim.errors import SimulationError
from cosim.fmu import Fmu

if TYPE_CHECKING:
    from cosim.prepared import Prepared

_lock = threading.Lock()
_holders: WeakValueDictionary[tuple[Path, str], Prepared] = WeakValueDictionary()


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
        for (binary, name), holder in _holders.items():
            if binary == fmu.binary and (name, holder) != (component, simulation):
                raise SimulationError(
                    f"{component}: {fmu.path.name} can be instantiated only once per process, and"
                    f" {name} of {holder.spec.system.name} has it; close that simulation first"
                )
        _holders[fmu.binary, component] = simulation


def give_up(simulation: Prepared) -> None:
    """Give back what a simulation has claimed."""
    with _lock:
        for key in [key for key, holder in _holders.items() if holder is simulation]:
            del _holders[key]
