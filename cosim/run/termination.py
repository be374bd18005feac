"""A run that an FMU asked to end: when, why, and with which outputs."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from stickslip.cosim import kernel
from stickslip.cosim.assembly.general_path import GeneralComponent
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.signals import Array

# Of ``fmi2StatusKind``.
_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3


def terminated(
    run: structures.Run,
    slot: structures.Component,
    general: GeneralComponent | None,
    library: Library,
) -> tuple[float, str] | None:
    """Return the time (s) at which an FMU ended a run and its reason; None when it failed."""
    if run.done < 0 or run.done >= run.n_steps or not slot.instance:
        return None
    if run.status == kernel.TERMINATED:
        reached = general.c.time if general else run.t + run.h
        return reached, "asked to terminate the simulation"
    if run.status == kernel.DISCARD and slot.version == 2:
        instance = general.c.instance if general else slot.instance
        if _ask(library, "fmi2GetBooleanStatus", instance, _TERMINATED, ctypes.c_int32()):
            reached = _ask(
                library, "fmi2GetRealStatus", instance, _LAST_SUCCESSFUL_TIME, ctypes.c_double()
            )
            reason = "discarded a step, as it had terminated"
            return run.start + run.done * run.step if reached is None else reached, reason
    return None


def last_outputs(slot: structures.Component) -> Array:
    """Return the outputs (n_outputs,) of an FMU that ended a run."""
    outputs = np.empty(slot.n_outputs)
    n = ctypes.c_size_t(len(outputs))
    arguments = [ctypes.c_void_p(slot.instance), slot.output_references, n, outputs.ctypes]
    get = structures.step_calls(slot.version).index(_GETTERS[slot.version])
    ctypes.CFUNCTYPE(ctypes.c_int)(slot.call[get])(*arguments, *[n] * (slot.version == 3))
    return outputs


_GETTERS = {2: "fmi2GetReal", 3: "fmi3GetFloat64"}


def _ask(library: Library, name: str, instance: int, kind: int, answer: Any) -> Any:
    """Return what an FMU says about its last step; None when it says nothing."""
    prototype = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
    status = prototype(library.address(name))(instance, kind, ctypes.byref(answer))
    return answer.value if status in {0, 1} else None
