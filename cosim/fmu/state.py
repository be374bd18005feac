"""The state of an FMU as bytes.

Source: FMI 2.0 section 2.1.8, FMI 3.0 section 2.2.6.4.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from ctypes import byref, c_char, c_size_t, c_void_p
from typing import Any

from stickslip.cosim import kernel
from stickslip.cosim.errors import SimulationError
from stickslip.cosim.fmu.batch import Batch
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import marks
from stickslip.cosim.kernel.arithmetic import plain_arithmetic

_log = logging.getLogger(__name__)
_LARGEST = 2**30  # bytes of a state


class StateAccess:
    """Saves, restores and reads one instance.

    Parameters
    ----------
    name : of the component, for messages
    version : of FMI, 2 or 3
    library : of the FMU
    instance : its address
    on_fatal : called with the name when the FMU answers fatal
    """

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
        try:
            self._call(self._size, state, byref(size))
            possible = 0 < size.value <= _LARGEST
            self._require(
                possible, f"{self._size} gave {size.value} bytes as the size of the state"
            )
            room = (c_char * size.value)()
            self._call(self._serialize, state, room, size)
            self._call(self._size, state, byref(now))
            same = now.value == size.value
            self._require(same, f"{self._size} gave {size.value} bytes, then {now.value}")
        except SimulationError:
            self._let_go(state)
            raise
        self._call(self._free, byref(state))
        return bytes(room)

    def restore(self, data: bytes) -> None:
        """Bring a saved state back."""
        state, size = c_void_p(), c_size_t(len(data))
        room = (c_char * len(data)).from_buffer_copy(data)
        self._call(self._deserialize, room, size, byref(state))
        self._require(state.value is not None, f"{self._deserialize} gave no state")
        try:
            self._call(self._set, state)
        except SimulationError:
            self._let_go(state)
            raise
        self._call(self._free, byref(state))

    def read(self, batch: Batch) -> None:
        """Read the values of variables."""
        count, size = len(batch.references), (c_size_t(len(batch.values)),)
        sizes = size if self._version == 3 else ()
        self._call(batch.call, batch.references, c_size_t(count), batch.values, *sizes)

    def _let_go(self, state: c_void_p) -> None:
        if self._instance:
            with plain_arithmetic():
                self._library.function(self._free)(self._instance, byref(state))

    def _require(self, condition: bool, what: str) -> None:
        if not condition:
            raise SimulationError(f"{self._name}: {what}, though the FMU declares that it can")

    def _call(self, name: str, *arguments: Any) -> None:
        marks.note(self._name, name)
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
