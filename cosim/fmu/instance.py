"""Instances of FMUs: values by type, states as bytes, and what all of a process share."""

from __future__ import annotations

import ctypes
import logging
import threading
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from ctypes import byref, c_char, c_size_t, c_void_p
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

from stickslip.cosim import kernel
from stickslip.cosim.component import Component
from stickslip.cosim.errors import SimulationError
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import plain_arithmetic
from stickslip.cosim.kernel.structures import STORED, Group
from stickslip.fmi.description.variables import Value, Variable


class Batch:
    """Room for the values of some variables of one type; arrays lie row by row."""

    def __init__(self, library: Library, variables: list[Variable], verb: str) -> None:
        self.call, self.address, self._type = library.accessor(variables[0].type, verb)
        self.discrete = variables[0].is_discrete
        self.clock = variables[0].type == "Clock"
        self.references = (ctypes.c_uint32 * len(variables))(*(v.reference for v in variables))
        self._first: dict[str, int] = {}
        size = 0
        for variable in variables:
            self._first[variable.name] = size
            size += variable.size
        self.values = (self._type * size)()
        binary = variables[0].type == "Binary"
        self._sizes = (ctypes.c_size_t * size)() if binary else None
        for variable in variables:
            if variable.start is not None:
                self.put(variable, variable.start)

    def place(self, variable: Variable) -> int:
        """Return where the values of a variable, or the value of an element, begin."""
        return self._first[variable.owner] + variable.element

    def holds(self, variable: Variable) -> bool:
        """Return whether it has room for a variable, or for the array of an element."""
        return variable.owner in self._first

    def put(self, variable: Variable, value: Value) -> None:
        """Write a value that was checked."""
        first = self.place(variable)
        for i, item in enumerate(value if isinstance(value, tuple) else (value,), first):
            encoded: Any = item.encode() if isinstance(item, str) else item
            self.values[i] = encoded
            if self._sizes is not None:
                self._sizes[i] = len(encoded)

    def group(self) -> Group:
        """Return it as the kernel takes it."""
        return Group(
            self.address,
            self.call.encode(),
            [*STORED.values()].index(self._type),
            self.discrete,
            self.clock,
            len(self.references),
            self.references,
            len(self.values),
            ctypes.cast(self.values, ctypes.c_void_p),
            self._sizes,
        )


def batches(library: Library, variables: Iterable[Variable], verb: str) -> list[Batch]:
    """Sort variables, none of them an element, into batches; ``verb`` is Get or Set."""
    members: dict[tuple[str, bool], list[Variable]] = defaultdict(list)
    for variable in variables:
        members[variable.type, variable.is_discrete and verb == "Set"].append(variable)
    return [Batch(library, group, verb) for group in members.values()]


_log = logging.getLogger(__name__)
_LARGEST = 2**30  # bytes of a state


class StateAccess:
    """Saves, restores and reads one instance; ``on_fatal`` is called with its name."""

    def __init__(
        self,
        name: str,
        version: int,
        library: Library,
        instance: int,
        on_fatal: Callable[[str], object],
    ) -> None:
        self._name = name
        self._library, self._version = library, version
        self._instance, self._mark_fatal = c_void_p(instance), on_fatal
        word = "FMUstate" if version == 2 else "FMUState"
        verbs = ("Get{}", "Set{}", "Free{}", "Serialized{}Size", "Serialize{}", "Deserialize{}")
        names = [f"fmi{version}{verb.format(word)}" for verb in verbs]
        if version == 2:
            names[-1] = "fmi2DeSerializeFMUstate"
        self._get, self._set, self._free, self._size, self._serialize, self._deserialize = names

    def save(self) -> bytes:
        """Return the state."""
        state, size, now = c_void_p(), c_size_t(), c_size_t()
        self._call(self._get, byref(state))
        self._require(state.value is not None, f"{self._get} gave no state")
        with self._freed(state):
            self._call(self._size, state, byref(size))
            what = f"{self._size} gave {size.value} bytes"
            self._require(0 < size.value <= _LARGEST, f"{what} as the size of the state")
            room = (c_char * size.value)()
            self._call(self._serialize, state, room, size)
            self._call(self._size, state, byref(now))
            self._require(now.value == size.value, f"{what}, then {now.value}")
        return bytes(room)

    def restore(self, data: bytes) -> None:
        """Bring a saved state back."""
        state, size = c_void_p(), c_size_t(len(data))
        room = (c_char * len(data)).from_buffer_copy(data)
        self._call(self._deserialize, room, size, byref(state))
        self._require(state.value is not None, f"{self._deserialize} gave no state")
        with self._freed(state):
            self._call(self._set, state)

    def read(self, batch: Batch) -> None:
        """Read the values of variables."""
        count, size = len(batch.references), (c_size_t(len(batch.values)),)
        sizes = size if self._version == 3 else ()
        self._call(batch.call, batch.references, c_size_t(count), batch.values, *sizes)

    @contextmanager
    def _freed(self, state: c_void_p) -> Iterator[None]:
        try:
            yield
        except SimulationError:
            if self._instance:
                with plain_arithmetic():
                    self._library.function(self._free)(self._instance, byref(state))
            raise
        self._call(self._free, byref(state))

    def _require(self, condition: bool, what: str) -> None:
        if not condition:
            raise SimulationError(f"{self._name}: {what}, though the FMU declares that it can")

    def _call(self, name: str, *arguments: Any) -> None:
        kernel.note_call(self._name, name)
        with plain_arithmetic():
            status = self._library.function(name)(self._instance, *arguments)
        if status == kernel.WARNING:
            _log.warning("%s: %s returned warning", self._name, name)
        elif status != kernel.OK:
            if status == kernel.FATAL:
                self._instance = c_void_p()
                self._mark_fatal(self._name)
            what = kernel.STATUS.get(status) if status <= kernel.PENDING else None
            what = what or f"returned the unknown status {status}"
            raise SimulationError(f"{self._name}: {name} {what}")


# Anywhere here a simulation may be collected, which then gives up what it has, in this very thread.
_lock = threading.RLock()
_times: Counter[Path] = Counter()  # fatal answers
_held: WeakKeyDictionary[object, tuple[str, dict[str, Path]]] = WeakKeyDictionary()
"""Simulation -> name of its system, and the binaries of which it has the only instance."""


def claim(fmu: Component, component: str, simulation: object, system: str) -> None:
    """Reserve for a simulation the only instance of an FMU that allows one per process."""
    if not fmu.once_per_process:
        return
    with _lock:
        for holder, (owner, binaries) in list(_held.items()):
            for name, binary in binaries.items():
                if binary == fmu.binary and (name, holder) != (component, simulation):
                    what = f"instantiated only once per process, and {name} of {owner} has it"
                    advice = "close that simulation first"
                    raise SimulationError(f"{component}: {fmu.label} can be {what}; {advice}")
        _held.setdefault(simulation, (system, {}))[1][component] = fmu.binary


def release(simulation: object) -> None:
    """Give back what a simulation has claimed."""
    with _lock:
        _held.pop(simulation, None)


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
