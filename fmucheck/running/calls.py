"""Calls into a library and from it: what their status means, the logger, memory."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Sequence
from ctypes import CDLL, CFUNCTYPE, Structure, c_char_p, c_int, c_size_t, c_void_p
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stickslip.fmi.messages import named
from stickslip.fmucheck.description.model import Variable
from stickslip.fmucheck.running.printf import ARGUMENTS, formatted

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
        how = "is not exported" if status < 0 else f"returned {status_name(status)}"
        super().__init__(f"{function} {how}{why}")
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


_LIBC = ctypes.CDLL("msvcrt" if sys.platform == "win32" else None)
_LIBC.calloc.restype = c_void_p
_LIBC.calloc.argtypes = (c_size_t, c_size_t)
_LIBC.free.argtypes = (c_void_p,)

MOST_MESSAGES = 10_000  # kept of one instance
LOGGER2 = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, *ARGUMENTS)
LOGGER3 = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
_ALLOCATE = CFUNCTYPE(c_void_p, c_size_t, c_size_t)
_FREE = CFUNCTYPE(None, c_void_p)
_FINISHED = CFUNCTYPE(None, c_void_p, c_int)


class Callbacks2(Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", LOGGER2),
        ("allocate", _ALLOCATE),
        ("free", _FREE),
        ("finished", _FINISHED),
        ("environment", c_void_p),
    )


@dataclass(frozen=True)
class Message:
    """What an FMU logged; ``None`` where it passed a null pointer."""

    status: int
    category: str | None
    text: str | None
    environment: int | None


def _word(text: bytes | None) -> str | None:
    return None if text is None else text.decode("utf-8", "replace")


@dataclass
class Callbacks:
    """The callbacks of one instance, and what came through them. Must outlive the instance."""

    variables: Sequence[Variable] = ()
    messages: list[Message] = field(default_factory=list)
    allocated: int = 0

    def __post_init__(self) -> None:
        self._place = ctypes.create_string_buffer(1)
        self.environment = ctypes.addressof(self._place)
        self.logger2 = LOGGER2(self._log2)
        self.logger3 = LOGGER3(self._log3)
        self.functions = Callbacks2(
            self.logger2,
            _ALLOCATE(self._allocate),
            _FREE(self._free),
            _FINISHED(),
            self.environment,
        )

    def _log2(
        self,
        place: int | None,
        _: bytes,
        status: int,
        category: bytes | None,
        text: bytes | None,
        *arguments: float,
    ) -> None:
        if len(self.messages) < MOST_MESSAGES:
            if text is not None:
                known = ((v.kind, v.reference, v.name) for v in self.variables)
                text = named(_word(formatted(text, arguments)) or "", known).encode()
            self._log3(place, status, category, text)

    def _log3(
        self, place: int | None, status: int, category: bytes | None, text: bytes | None
    ) -> None:
        if len(self.messages) < MOST_MESSAGES:
            self.messages.append(Message(status, _word(category), _word(text), place))

    def _allocate(self, count: int, size: int) -> int | None:
        self.allocated += 1
        found: int | None = _LIBC.calloc(count, size)
        return found

    def _free(self, memory: int | None) -> None:
        _LIBC.free(memory)
