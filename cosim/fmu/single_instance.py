"""What simulations of one process share: the only instance of an FMU, and fatal answers."""

from __future__ import annotations

import threading
from collections import Counter
from pathlib import Path
from weakref import ref

from stickslip.cosim.component import Component
from stickslip.cosim.errors import SimulationError

# Anywhere here a simulation may be collected, which then gives up what it has, in this very thread.
_lock = threading.RLock()
_times: Counter[Path] = Counter()  # fatal answers
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


def note_fatal(binary: Path) -> None:
    """Note that an FMU answered fatal: instances of that FMU are not called again.

    Source: FMI 2.0 section 2.1.3, FMI 3.0 section 2.2.3 (fatal corrupts all instances).
    """
    with _lock:
        _times[binary] += 1


def none_fatal() -> bool:
    """Return whether no FMU did."""
    return not _times


def times_fatal(binary: Path) -> int:
    """Return how often an FMU did; an instance made when it was less may not be called."""
    return _times[binary]
