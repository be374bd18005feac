"""One instance of an FMU, with the same methods for both versions of the standard."""

import ctypes
from collections.abc import Sequence
from ctypes import Structure, byref, c_bool, c_double, c_int, c_size_t, c_void_p
from dataclasses import dataclass
from typing import Any

from stickslip.fmi.description.variables import SETTERS
from stickslip.fmucheck.description.model import Description, Variable
from stickslip.fmucheck.running import calls
from stickslip.fmucheck.running.calls import Binary, Callbacks

Values = tuple[Any, ...]
_TERMINATED = 3  # fmi2StatusKind


class _EventInfo(Structure):
    _flags = ("more", "end", "nominals", "changed", "has_time")
    _fields_ = (*((name, c_int) for name in _flags), ("time", c_double))


@dataclass
class Event:
    """The answer of an FMU to an event: whether to end, and when the next one is."""

    more: bool
    end: bool = False
    next_time: float | None = None


class Instance:
    """An instance. Calls raise ``CallFailed`` unless they answer OK or Warning."""

    event_mode = False
    """Whether Co-Simulation was instantiated with events left to the importer."""

    def __init__(
        self, binary: Binary, description: Description, handle: int, callbacks: Callbacks
    ) -> None:
        self.binary, self.description = binary, description
        self.handle, self.callbacks = c_void_p(handle), callbacks  # an int would pass as 32 bits
        self.warned: list[str] = []
        self.broken = False
        self.two = description.version == 2
        self.state_name = "FMUstate" if self.two else "FMUState"
        self._flag = c_int if self.two else c_bool

    def do(self, name: str, *arguments: Any) -> None:
        """Call a function of this instance that must succeed."""
        self.broken = True  # until it has returned well
        if self.binary.do(name, self.handle, *arguments):
            self.warned.append(name)
        self.broken = False

    def status(self, name: str, *arguments: Any) -> int:
        """Call a function of this instance and return its status."""
        return self.binary.call(name, self.handle, *arguments)

    def get(self, variables: Sequence[Variable]) -> list[Values]:
        """Return the values of variables, each as a tuple of its elements."""
        found: dict[int, Values] = {}
        for kind in dict.fromkeys(v.kind for v in variables):
            group = [v for v in variables if v.kind == kind]
            sizes = [self.description.size(v) or 1 for v in group]
            flat = self._get(kind, [v.reference or 0 for v in group], sum(sizes))
            place = 0
            for v, count in zip(group, sizes, strict=True):
                found[v.index] = tuple(flat[place : place + count])
                place += count
        return [found[v.index] for v in variables]

    def set(self, variable: Variable, values: Values) -> None:
        """Set a variable, all its elements."""
        name, c_type = SETTERS[self.description.version][variable.kind]
        array = (c_type * len(values))(*values)
        self._access(name[4:], [variable.reference or 0], array, len(values))

    def _get(self, kind: str, numbers: list[int], count: int) -> list[Any]:
        name, c_type = SETTERS[self.description.version][kind]
        array: Any = ((c_void_p if kind == "Binary" else c_type) * count)()
        if kind != "Binary":
            self._access(f"Get{name[7:]}", numbers, array, count)
            return list(array)
        sizes = (c_size_t * count)()
        n, total = c_size_t(len(numbers)), c_size_t(count)
        self.do("GetBinary", calls.references(numbers), n, sizes, array, total)
        pairs = zip(array, sizes, strict=True)
        return [ctypes.string_at(p, s) if p else None for p, s in pairs]

    def _access(self, name: str, numbers: list[int], array: Any, count: int) -> None:
        counts = [] if self.two else [c_size_t(count)]
        self.do(name, calls.references(numbers), c_size_t(len(numbers)), array, *counts)

    def enter_initialisation(
        self, start: float, parameters: Sequence[tuple[Variable, Values]] = ()
    ) -> None:
        """Set parameters, after SetupExperiment as tools do, and enter initialisation mode."""
        nothing, no = c_double(0.0), self._flag(False)
        times = (no, nothing, c_double(start), no, nothing)
        if self.two:
            self.do("SetupExperiment", *times)
        for variable, values in parameters:
            self.set(variable, values)
        self.do("EnterInitializationMode", *(() if self.two else times))

    def attempt_step(self, time: float, step: float) -> tuple[int, tuple[Any, ...]]:
        """Return the status of a communication step; event, end, early return and last time."""
        answers = c_bool(), c_bool(), c_bool(), c_double()
        given = c_double(time), c_double(step), self._flag(False)
        places = [] if self.two else [byref(answer) for answer in answers]
        status = self.status("DoStep", *given, *places)
        if self.two and status == calls.DISCARD:
            ended = c_int()
            self.status("GetBooleanStatus", c_int(_TERMINATED), byref(ended))
            answers[1].value = bool(ended.value)
        return status, tuple(answer.value for answer in answers)

    def step(self, time: float, step: float) -> bool:
        """Do one communication step; return whether the FMU wants the run to end."""
        self.broken = True
        status, (event, end, early, last) = self.attempt_step(time, step)
        if status not in (calls.OK, calls.WARNING) and not (self.two and end):
            why = f" for the step from {time} by {step}"
            raise calls.CallFailed(f"{self.binary.prefix}DoStep", status, why)
        if status == calls.WARNING:
            self.warned.append("DoStep")
        self.broken = False
        if early and not end:
            raise calls.CallFailed("fmi3DoStep", 0, f" early at {last}, though that is not allowed")
        if event and self.event_mode:
            self.do("EnterEventMode")
            self.leave_event_mode()
        return bool(end)

    def update_discrete_states(self) -> Event:
        """Do one iteration of an event."""
        info = _EventInfo()
        if self.two:
            self.do("NewDiscreteStates", byref(info))
            flags = [info.more, info.end, info.has_time]
        else:
            answers = [c_bool() for _ in range(5)]
            time = c_double()
            self.do("UpdateDiscreteStates", *map(byref, answers), byref(time))
            flags = [answers[k].value for k in (0, 1, 4)]
            info.time = time.value
        more, end, has_time = map(bool, flags)
        return Event(more, end, info.time if has_time else None)

    def complete_step(self) -> tuple[bool, bool]:
        """Complete an integration step; return whether there is an event, and the end."""
        event, end = self._flag(), self._flag()
        self.do("CompletedIntegratorStep", self._flag(), byref(event), byref(end))
        return bool(event.value), bool(end.value)

    def leave_event_mode(self) -> None:
        """Iterate an event of Co-Simulation until nothing changes, and go back to stepping."""
        for _ in range(100):
            if not self.update_discrete_states().more:
                break
        self.do("EnterStepMode")

    def vector(self, name: str, count: int) -> list[float]:
        """Call a getter of a vector, such as ContinuousStates."""
        array = (c_double * count)()
        if count:
            self.do(f"Get{name}", array, c_size_t(count))
        return list(array)

    def set_states(self, states: Sequence[float]) -> None:
        """Set the continuous states."""
        if states:
            array = (c_double * len(states))(*states)
            self.do("SetContinuousStates", array, c_size_t(len(states)))

    def save(self, state: c_void_p | None = None) -> c_void_p:
        """Return a copy of the complete state, in ``state`` if one is given."""
        state = state or c_void_p()
        self.do(f"Get{self.state_name}", byref(state))
        return state

    def restore(self, state: c_void_p) -> None:
        """Go back to a saved state."""
        self.do(f"Set{self.state_name}", state)

    def free_state(self, state: c_void_p) -> None:
        """Free a saved state; the pointer is then null, if the FMU does it right."""
        self.do(f"Free{self.state_name}", byref(state))

    def serialise(self, state: c_void_p) -> bytes:
        """Return a saved state as bytes."""
        count = c_size_t()
        self.do(f"Serialized{self.state_name}Size", state, byref(count))
        memory = (c_size_t * (count.value // 8 + 1))()
        self.do(f"Serialize{self.state_name}", state, memory, count)
        return bytes(memory)[: count.value]

    def deserialise(self, content: bytes) -> c_void_p:
        """Return a saved state from bytes."""
        state = c_void_p()
        kind = c_size_t * (len(content) // 8 + 1)
        memory = kind.from_buffer_copy(content.ljust(len(content) + 8))
        name = f"De{'S' if self.two else 's'}erialize{self.state_name}"
        self.do(name, memory, c_size_t(len(content)), byref(state))
        return state

    def free(self) -> None:
        """Free the instance."""
        self.binary.function("FreeInstance", None)(self.handle)
