"""FMUs that a reset does not bring back to their start: each of their runs has a new instance."""

import logging
import threading
from collections.abc import Iterable, Sequence
from pathlib import Path

from stickslip.cosim.system.system import System

_log = logging.getLogger(__name__)
_lock = threading.Lock()
lines: dict[Path, str] = {}  # what is known in this process: binary -> the line that was logged
crashed: set[Path] = set()
"""Binaries that crashed or hung when they were used again: each isolated run has a new child."""


def declare(binaries: Iterable[Path], line: str) -> None:
    """Note that FMUs need new instances; log why, unless that was known of all of them."""
    with _lock:
        new = [binary for binary in binaries if binary not in lines]
        lines.update(dict.fromkeys(new, line))
    if new:
        _log.warning("%s", line)


def declare_unresettable(system: System, names: Sequence[str], what: str) -> None:
    """Note that components cannot be used again after a reset, and what shows it."""
    said = f"cannot be used again after a reset: {what}; each run has a new instance of it"
    _declare(system, names, said)


def declare_erratic(system: System, names: Sequence[str], what: str) -> None:
    """Note that new instances of components do not do the same, and what shows it."""
    _declare(
        system,
        names,
        f"gives other results in the same run with another new instance: {what}; it cannot be seen"
        " whether a reset works, so each run has new instances; if the FMU keeps something in"
        " static variables, each run needs a process of its own (isolation='process', and close()"
        " after each run)",
    )


def _declare(system: System, names: Sequence[str], what: str) -> None:
    fmus = [system.components[name] for name in names]
    each = [f"{name} ({fmu.label})" for name, fmu in zip(names, fmus, strict=True)]
    who = each[0] if len(each) == 1 else f"one of {', '.join(each)}"
    declare([fmu.binary for fmu in fmus], f"{who} {what}")
