"""FMI 2.0."""

from __future__ import annotations

from ctypes import Structure, byref, c_char_p, c_double, c_int, c_int32, c_size_t
from typing import Any, ClassVar

from stickslip.fmucheck.running.calls import DISCARD, OK, WARNING, CallFailed, references
from stickslip.fmucheck.running.instance import Event, Instance

_TERMINATED = 3  # fmi2StatusKind


class _EventInfo(Structure):
    _fields_ = (
        *((name, c_int) for name in ("more", "end", "nominals", "values", "has_time")),
        ("time", c_double),
    )


class Instance2(Instance):
    """An instance of an FMU of FMI 2.0."""

    C_TYPES: ClassVar = {
        "Real": ("Real", c_double),
        "Integer": ("Integer", c_int32),
        "Enumeration": ("Integer", c_int32),
        "Boolean": ("Boolean", c_int32),
        "String": ("String", c_char_p),
    }
    STATE = "FMUstate"
    DESERIALISE = "DeSerializeFMUstate"

    def _get_arguments(self, numbers: list[int], array: Any, _: int) -> tuple[Any, ...]:
        return references(numbers), c_size_t(len(numbers)), array

    def _set(self, name: str, numbers: Any, array: Any, _: int) -> None:
        self.do(f"Set{name}", numbers, c_size_t(len(numbers)), array)

    def enter_initialisation(self, start: float) -> None:
        nothing, no = c_double(0.0), c_int(0)
        self.do("SetupExperiment", no, nothing, c_double(start), no, nothing)
        self.do("EnterInitializationMode")

    def step(self, time: float, step: float) -> bool:
        self.broken = True
        status = self.status("DoStep", c_double(time), c_double(step), c_int(0))
        if status == DISCARD:
            ended = c_int(0)
            self.status("GetBooleanStatus", c_int(_TERMINATED), byref(ended))
            if ended.value:
                self.broken = False
                return True
        if status not in (OK, WARNING):
            raise CallFailed("fmi2DoStep", status, f" for the step from {time} by {step}")
        if status:
            self.warned.append("DoStep")
        self.broken = False
        return False

    def update_discrete_states(self) -> Event:
        info = _EventInfo()
        self.do("NewDiscreteStates", byref(info))
        return Event(
            more=bool(info.more),
            end=bool(info.end),
            changed=bool(info.values),
            next_time=info.time if info.has_time else None,
        )

    def complete_step(self) -> tuple[bool, bool]:
        event, end = c_int(0), c_int(0)
        self.do("CompletedIntegratorStep", c_int(0), byref(event), byref(end))
        return bool(event.value), bool(end.value)
