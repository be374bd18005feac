"""FMI 3.0."""

from __future__ import annotations

from ctypes import (
    byref,
    c_bool,
    c_char_p,
    c_double,
    c_float,
    c_int8,
    c_int16,
    c_int32,
    c_int64,
    c_size_t,
    c_uint8,
    c_uint16,
    c_uint32,
    c_uint64,
    c_void_p,
    string_at,
)
from typing import Any, ClassVar

from stickslip.fmucheck.running.calls import CallFailed, references
from stickslip.fmucheck.running.instance import Event, Instance


class Instance3(Instance):
    """An instance of an FMU of FMI 3.0."""

    C_TYPES: ClassVar = {
        "Float32": ("Float32", c_float),
        "Float64": ("Float64", c_double),
        "Int8": ("Int8", c_int8),
        "UInt8": ("UInt8", c_uint8),
        "Int16": ("Int16", c_int16),
        "UInt16": ("UInt16", c_uint16),
        "Int32": ("Int32", c_int32),
        "UInt32": ("UInt32", c_uint32),
        "Int64": ("Int64", c_int64),
        "UInt64": ("UInt64", c_uint64),
        "Enumeration": ("Int64", c_int64),
        "Boolean": ("Boolean", c_bool),
        "String": ("String", c_char_p),
        "Binary": ("Binary", c_void_p),
    }

    def _get(self, kind: str, numbers: list[int], count: int) -> list[Any]:
        if kind != "Binary":
            return super()._get(kind, numbers, count)
        sizes, array = (c_size_t * count)(), (c_void_p * count)()
        n, total = c_size_t(len(numbers)), c_size_t(count)
        self.do("GetBinary", references(numbers), n, sizes, array, total)
        return [string_at(p, s) if p else None for p, s in zip(array, sizes, strict=True)]

    def _get_arguments(self, numbers: list[int], array: Any, count: int) -> tuple[Any, ...]:
        return references(numbers), c_size_t(len(numbers)), array, c_size_t(count)

    def _set(self, name: str, numbers: Any, array: Any, count: int) -> None:
        self.do(f"Set{name}", numbers, c_size_t(len(numbers)), array, c_size_t(count))

    def enter_initialisation(self, start: float) -> None:
        nothing, no = c_double(0.0), c_bool(False)
        self.do("EnterInitializationMode", no, nothing, c_double(start), no, nothing)

    def step(self, time: float, step: float) -> bool:
        event, end, early, last = c_bool(), c_bool(), c_bool(), c_double()
        results = byref(event), byref(end), byref(early), byref(last)
        self.do("DoStep", c_double(time), c_double(step), c_bool(False), *results)
        if early.value and not end.value:
            raise CallFailed("fmi3DoStep", 0, f" early at {last.value}, though that is not allowed")
        if event.value and self.event_mode:
            self.do("EnterEventMode")
            self.leave_event_mode()
        return end.value

    def update_discrete_states(self) -> Event:
        more, end, nominals, values, has_time = (c_bool() for _ in range(5))
        time = c_double()
        flags = byref(more), byref(end), byref(nominals), byref(values), byref(has_time)
        self.do("UpdateDiscreteStates", *flags, byref(time))
        return Event(
            more=more.value,
            end=end.value,
            changed=values.value,
            next_time=time.value if has_time.value else None,
        )

    def complete_step(self) -> tuple[bool, bool]:
        event, end = c_bool(), c_bool()
        self.do("CompletedIntegratorStep", c_bool(False), byref(event), byref(end))
        return event.value, end.value
