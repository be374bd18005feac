"""Raw calls into a library, and what their status means."""

from __future__ import annotations

import ctypes
import os
from ctypes import CDLL, c_int, c_void_p
from pathlib import Path
from typing import Any

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
_NAMES = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")


def status_name(status: int) -> str:
    """Return what the standard calls a status."""
    return _NAMES[status] if 0 <= status < len(_NAMES) else f"unknown status {status}"


class CallFailed(Exception):
    """A function did not do what it must be able to do.

    ``status`` is what it returned, -1 when the library does not have it.
    """

    def __init__(self, function: str, status: int, why: str = "") -> None:
        said = "is not exported" if status < 0 else f"returned {status_name(status)}"
        super().__init__(f"{function} {said}{why}")
        self.function, self.status = function, status


class Binary:
    """A loaded library.

    Raises
    ------
    OSError
        When the system cannot load it.
    """

    def __init__(self, path: Path, version: int) -> None:
        self.prefix = f"fmi{version}"
        if hasattr(os, "add_dll_directory"):
            os.add_dll_directory(str(path.parent))
        self._library = CDLL(str(path))

    def has(self, name: str) -> bool:
        """Tell whether a function, named without its prefix, is exported."""
        return hasattr(self._library, self.prefix + name)

    def function(self, name: str, result: Any = c_int) -> Any:
        """Return a function by its name without prefix, with what it returns.

        Raises
        ------
        CallFailed
            When the library does not export it.
        """
        try:
            found = self._library[self.prefix + name]
        except AttributeError:
            raise CallFailed(self.prefix + name, -1) from None
        found.restype = result
        return found

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function that returns a status, and return it."""
        return int(self.function(name)(*arguments))

    def do(self, name: str, *arguments: Any) -> int:
        """Call a function that must succeed.

        Raises
        ------
        CallFailed
            When it returns neither OK nor Warning.
        """
        status = self.call(name, *arguments)
        if status not in (OK, WARNING):
            raise CallFailed(self.prefix + name, status)
        return status


def references(numbers: list[int]) -> Any:
    """Return value references as C takes them."""
    return (ctypes.c_uint32 * len(numbers))(*numbers)


def pointer(handle: Any) -> c_void_p:
    """Return a handle as a pointer; ctypes would pass an int as 32 bits."""
    return handle if isinstance(handle, c_void_p) else c_void_p(handle)
