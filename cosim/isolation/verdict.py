"""The error when a child died: component, call, time and cause."""

from __future__ import annotations

import ctypes
import math
import signal
from collections.abc import Sequence
from dataclasses import dataclass

from stickslip.cosim import kernel
from stickslip.cosim.errors import FmuCrashed
from stickslip.cosim.isolation.answers import LOST
from stickslip.cosim.kernel.marks import Mark
from stickslip.cosim.system.system import System

_UNTIMED = ("load", "unload", "Instantiate", "FreeInstance")  # the time says nothing of these


@dataclass(frozen=True)
class Death:
    """How a child ended.

    Attributes
    ----------
    what : happened, such as ``died of SIGSEGV``
    printed : the last line that was printed
    """

    what: str
    printed: str = ""

    @classmethod
    def of(cls, status: int | None, printed: str, memory: float | None = None) -> Death:
        """Return what an exit status says; None stands for a child that could not be reached.

        ``memory`` (MB) is what it might take where it came near that, else None.
        """
        if status is None or status == LOST:
            return cls("or a call before it closed files that are not its own", printed)
        if status < 0:
            limit = f" (it may take {memory:g} MB of memory)" if memory else ""
            return cls(f"died of {_signal_name(-status)}{limit}", printed)
        return cls(f"ended its process with status {status}", printed)


def crashed(mark: Mark, system: System, order: Sequence[str], death: Death) -> FmuCrashed:
    """Return the error that says it all in one line.

    Parameters
    ----------
    mark : the call it was in
    order : names of the components as they step
    """
    call = mark.call.decode(errors="replace") or "its process"
    name = called(mark, order) or mark.name.decode(errors="replace")
    if name in system.components:
        name = f"{name} ({system.components[name].label})"
    name = name or ", ".join(sorted({fmu.label for fmu in system.components.values()}))
    when = ""
    if not any(word in call for word in _UNTIMED):
        when = f" at t = {mark.t:.9g} s" if math.isfinite(mark.t) else " during initialisation"
    printed = f"; it printed: {death.printed}" if death.printed else ""
    return FmuCrashed(f"{name}: {call} {death.what}{when}{printed}")


def called(mark: Mark, order: Sequence[str]) -> str | None:
    """Return the component that was called, None where the kernel called none."""
    if not (mark.component and mark.first):
        return None
    place, rest = divmod(mark.component - mark.first, ctypes.sizeof(kernel.Component))
    return None if rest or not 0 <= place < len(order) else order[place]


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
