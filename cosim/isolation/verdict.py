"""The error when a child died: component, call, time and cause."""

from __future__ import annotations

import ctypes
import math
import signal
from collections.abc import Sequence

from stickslip.cosim.errors import FmuCrashed
from stickslip.cosim.isolation.messages import LOST
from stickslip.cosim.kernel import structures
from stickslip.cosim.kernel.structures import Mark
from stickslip.cosim.system.system import System

_UNTIMED = ("load", "unload", "Instantiate", "FreeInstance")  # calls at no simulated time


def ending(status: int | None, memory: float | None = None) -> str:
    """Describe an exit status, None if unreachable; ``memory`` (MB) is a limit that was near."""
    if status is None or status == LOST:
        return "or a call before it closed files that are not its own"
    if status >= 0:
        return f"ended its process with status {status}"
    limit = f" (it may take {memory:g} MB of memory)" if memory else ""
    known = -status in set(signal.Signals)
    return f"died of {signal.Signals(-status).name if known else f'signal {-status}'}{limit}"


def crashed(
    mark: Mark,
    system: System,
    order: Sequence[str],
    what: str,
    printed: str = "",
    denied: Sequence[str] = (),
) -> FmuCrashed:
    """Return the error: what happened in the call of the mark, what was printed and denied."""
    call = mark.call.decode(errors="replace") or "its process"
    when = ""
    if not any(word in call for word in _UNTIMED):
        when = f" at t = {mark.t:.9g} s" if math.isfinite(mark.t) else " during initialisation"
    printed = f"; it printed: {printed}" if printed else ""
    return FmuCrashed(
        f"{present(mark, system, order)} {what}{when}{printed}{'; '.join(['', *denied])}"
    )


def present(mark: Mark, system: System, order: Sequence[str]) -> str:
    """Return the component and the call it is in, such as ``drive (drive.fmu): fmi2DoStep``."""
    call = mark.call.decode(errors="replace") or "its process"
    name = called(mark, order) or mark.name.decode(errors="replace")
    if name in system.components:
        name = f"{name} ({system.components[name].label})"
    name = name or ", ".join(sorted({fmu.label for fmu in system.components.values()}))
    return f"{name}: {call}"


def called(mark: Mark, order: Sequence[str]) -> str | None:
    """Return the component that was called, None where the kernel called none."""
    if not (mark.component and mark.first):
        return None
    place, rest = divmod(mark.component - mark.first, ctypes.sizeof(structures.Component))
    return None if rest or not 0 <= place < len(order) else order[place]
