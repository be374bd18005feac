"""One instance of an FMU, with the same face for both versions of the standard."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from ctypes import byref, c_double, c_size_t, c_void_p
from typing import Any, ClassVar

from stickslip.fmucheck.description.model import Description, Variable, size
from stickslip.fmucheck.running.calls import Binary, Callbacks, pointer, references

Values = tuple[Any, ...]


class Event:
    """What an FMU says after an event: whether to end, and when the next one is."""

    def __init__(self, *, more: bool, end: bool, changed: bool, next_time: float | None) -> None:
        self.more, self.end, self.changed, self.next_time = more, end, changed, next_time


class Instance(ABC):
    """An instance. Calls raise ``CallFailed`` unless they answer OK or Warning."""

    C_TYPES: ClassVar[dict[str, tuple[str, Any]]]
    """Type of a variable -> what its functions are called, and the C type."""
    STATE = "FMUState"
    DESERIALISE = "DeserializeFMUState"
    event_mode = False
    """Whether Co-Simulation was instantiated with events left to the importer."""

    def __init__(
        self, binary: Binary, description: Description, handle: int, callbacks: Callbacks
    ) -> None:
        self.binary, self.description = binary, description
        self.handle, self.callbacks = pointer(handle), callbacks
        self.warned: list[str] = []
        self.broken = False

    def do(self, name: str, *arguments: Any) -> None:
        """Call a function of this instance that must succeed."""
        self.broken = True  # until it has returned well
        if self.binary.do(name, self.handle, *arguments):
            self.warned.append(name)
        self.broken = False

    def status(self, name: str, *arguments: Any) -> int:
        """Call a function of this instance and return its status."""
        return self.binary.call(name, self.handle, *arguments)

    # Values

    def get(self, variables: Sequence[Variable]) -> list[Values]:
        """Return the values of variables, each as a tuple of its elements."""
        found: dict[int, Values] = {}
        for kind in dict.fromkeys(v.kind for v in variables):
            group = [v for v in variables if v.kind == kind]
            sizes = [size(v, self.description) or 1 for v in group]
            flat = self._get(kind, [v.reference or 0 for v in group], sum(sizes))
            place = 0
            for v, count in zip(group, sizes, strict=True):
                found[v.index] = tuple(flat[place : place + count])
                place += count
        return [found[v.index] for v in variables]

    def set(self, variable: Variable, values: Values) -> None:
        """Set a variable, all its elements."""
        name, c_type = self.C_TYPES[variable.kind]
        array = (c_type * len(values))(*values)
        self._set(name, references([variable.reference or 0]), array, len(values))

    def _get(self, kind: str, numbers: list[int], count: int) -> list[Any]:
        name, c_type = self.C_TYPES[kind]
        array = (c_type * count)()
        self.do(f"Get{name}", *self._get_arguments(numbers, array, count))
        return list(array)

    @abstractmethod
    def _get_arguments(self, numbers: list[int], array: Any, count: int) -> tuple[Any, ...]: ...

    @abstractmethod
    def _set(self, name: str, numbers: Any, array: Any, count: int) -> None: ...

    # Life

    @abstractmethod
    def enter_initialisation(self, start: float) -> None:
        """Go from instantiated into initialisation mode."""

    def exit_initialisation(self) -> None:
        """Leave initialisation mode."""
        self.do("ExitInitializationMode")

    @abstractmethod
    def step(self, time: float, step: float) -> bool:
        """Do one communication step; return whether the FMU wants the run to end."""

    @abstractmethod
    def update_discrete_states(self) -> Event:
        """Do one iteration of an event."""

    @abstractmethod
    def complete_step(self) -> tuple[bool, bool]:
        """Tell that an integration step is done; return whether there is an event, and the end."""

    def leave_event_mode(self) -> None:
        """Iterate an event of Co-Simulation until nothing changes, and go back to stepping."""
        for _ in range(100):
            if not self.update_discrete_states().more:
                break
        self.do("EnterStepMode")

    # Model Exchange

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

    # State

    def save(self, state: c_void_p | None = None) -> c_void_p:
        """Return a copy of the complete state, in ``state`` if one is given."""
        state = state or c_void_p()
        self.do(f"Get{self.STATE}", byref(state))
        return state

    def restore(self, state: c_void_p) -> None:
        """Go back to a saved state."""
        self.do(f"Set{self.STATE}", state)

    def free_state(self, state: c_void_p) -> None:
        """Free a saved state; the pointer is then null, if the FMU does it right."""
        self.do(f"Free{self.STATE}", byref(state))

    def serialise(self, state: c_void_p) -> bytes:
        """Return a saved state as bytes."""
        count = c_size_t()
        self.do(f"Serialized{self.STATE}Size", state, byref(count))
        memory = (c_size_t * (count.value // 8 + 1))()
        self.do(f"Serialize{self.STATE}", state, memory, count)
        return bytes(memory)[: count.value]

    def deserialise(self, content: bytes) -> c_void_p:
        """Return a saved state from bytes."""
        state = c_void_p()
        memory = (c_size_t * (len(content) // 8 + 1)).from_buffer_copy(
            content.ljust(len(content) + 8)
        )
        self.do(self.DESERIALISE, memory, c_size_t(len(content)), byref(state))
        return state

    def free(self) -> None:
        """Free the instance."""
        self.binary.function("FreeInstance", None)(self.handle)
