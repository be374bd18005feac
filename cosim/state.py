"""The state of an FMU as bytes.

Source: FMI 2.0 section 2.1.8, FMI 3.0 section 2.2.6.4.
"""

from __future__ import annotations

from ctypes import byref, c_char, c_size_t, c_void_p
from typing import Any

from cosim.errors import SimulationError
from cosim.kernel import marks
from cosim.library import Library

_NAMES = {
    2: (
        "fmi2GetFMUstate",
        "fmi2SetFMUstate",
        "fmi2FreeFMUstate",
        "fmi2SerializedFMUstateSize",
        "fmi2SerializeFMUstate",
        "fmi2DeSerializeFMUstate",
    ),
    3: (
        "fmi3GetFMUState",
        "fmi3SetFMUState",
        "fmi3FreeFMUState",
        "fmi3SerializedFMUStateSize",
        "fmi3SerializeFMUState",
        "fmi3DeserializeFMUState",
    ),
}


class StateAccess:
    """Saves and restores one instance.

    Parameters
    ----------
    name : of the component, for messages
    version : of FMI, 2 or 3
    library : of the FMU
    instance : its address
    """

    def __init__(self, name: str, version: int, library: Library, instance: int) -> None:
        self._name = name
        self._library = library
        self._instance = c_void_p(instance)
        self._get, self._set, self._free, self._size, self._serialize, self._deserialize = _NAMES[
            version
        ]

    def save(self) -> bytes:
        """Return the state.

        Raises
        ------
        SimulationError
        """
        state, size = c_void_p(), c_size_t()
        self._call(self._get, byref(state))
        try:
            self._call(self._size, state, byref(size))
            room = (c_char * size.value)()
            self._call(self._serialize, state, room, size)
        finally:
            self._call(self._free, byref(state))
        return bytes(room)

    def restore(self, data: bytes) -> None:
        """Bring a saved state back.

        Raises
        ------
        SimulationError
        """
        state, size = c_void_p(), c_size_t(len(data))
        room = (c_char * len(data)).from_buffer_copy(data)
        self._call(self._deserialize, room, size, byref(state))
        try:
            self._call(self._set, state)
        finally:
            self._call(self._free, byref(state))

    def _call(self, name: str, *arguments: Any) -> None:
        marks.note(self._name, name)
        status = self._library.function(name)(self._instance, *arguments)
        if status > 1:  # neither OK nor a warning
            raise SimulationError(f"{self._name}: {name} returned status {status}")
