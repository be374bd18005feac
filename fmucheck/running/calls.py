"""Calls into a library and from it: what their status means, the logger, memory.

A callback in Python has no variable arguments. The logger of FMI 2.0 is declared with as many
further ones as the system passes in registers and, beyond, in eight words of the caller's stack.
"""

import ctypes
import os
import platform
import re
import sys
from collections.abc import Sequence
from ctypes import CFUNCTYPE, c_char_p, c_double, c_int, c_size_t, c_uint64, c_void_p
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stickslip.fmi.messages import named
from stickslip.fmucheck.description.model import Variable

_ON_STACK = 8
_REGISTERS = {"x86_64": (1, 8), "AMD64": (1, 8), "aarch64": (3, 8)}.get(platform.machine())
KNOWN = _REGISTERS is not None and sys.platform in ("linux", "win32")
# On Windows floating-point numbers lie among the others.
_N, _N_FLOATS = (_REGISTERS or (0, 0)) if sys.platform != "win32" else (0, 0)
_PASSED = (*[c_uint64] * (_N + _ON_STACK), *[c_double] * _N_FLOATS)
ARGUMENTS: tuple[Any, ...] = _PASSED if KNOWN else ()
"""C types of what follows the format."""
_LIBC = ctypes.CDLL("msvcrt" if sys.platform == "win32" else None)
_LONGEST = 10_000  # bytes of a message
_STORES = re.compile(rb"%%|%(?=[^%a-zA-Z]*[hlLjzt]*n)")  # %n: printf would write to memory
_SIZES = re.compile(rb"(%[^%a-zA-Z]*)[jzt]")  # which msvcrt spells otherwise
_NOTHING = (c_uint64(),) * 32  # for conversions beyond what was passed


def formatted(text: bytes, arguments: Sequence[float]) -> bytes:
    """Return a format with values of ``ARGUMENTS``, as printf writes it."""
    if not KNOWN:
        return text
    out, text = ctypes.create_string_buffer(_LONGEST), _STORES.sub(b"%%", text)
    passed = [kind(value) for kind, value in zip(ARGUMENTS, arguments, strict=True)]
    if sys.platform == "win32":
        text = _SIZES.sub(rb"\1I64", text)
    write = getattr(_LIBC, "_snprintf" if sys.platform == "win32" else "snprintf")
    write(out, c_size_t(_LONGEST - 1), text, *passed, *_NOTHING)
    return out.value


OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
_NAMES = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")


def status_name(status: int) -> str:
    """Return what the standard calls a status."""
    return _NAMES[status] if 0 <= status < len(_NAMES) else f"unknown status {status}"


class CallFailed(Exception):
    """A function failed; the status is -1 when the library does not have it."""

    def __init__(self, function: str, status: int, why: str = "") -> None:
        how = "is not exported" if status < 0 else f"returned {status_name(status)}"
        super().__init__(f"{function} {how}{why}")
        self.function, self.status = function, status


class Binary:
    """A loaded library; OSError when the system cannot load it."""

    def __init__(self, path: Path, version: int) -> None:
        self.prefix = f"fmi{version}"
        if hasattr(os, "add_dll_directory"):
            os.add_dll_directory(str(path.parent))
        self._library = ctypes.CDLL(str(path))

    def function(self, name: str, result: Any = c_int) -> Any:
        """Return a function by its name without prefix; CallFailed when it is not there."""
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
        """Call a function that must succeed; CallFailed when it returns neither OK nor Warning."""
        status = self.call(name, *arguments)
        if status not in (OK, WARNING):
            raise CallFailed(self.prefix + name, status)
        return status


def references(numbers: list[int]) -> Any:
    """Return value references as C takes them."""
    return (ctypes.c_uint32 * len(numbers))(*numbers)


_LIBC.calloc.restype = c_void_p
_LIBC.calloc.argtypes = (c_size_t, c_size_t)
_LIBC.free.argtypes = (c_void_p,)
MOST_MESSAGES = 10_000  # kept of one instance
LOGGER2 = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, *ARGUMENTS)
LOGGER3 = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
_ALLOCATE = CFUNCTYPE(c_void_p, c_size_t, c_size_t)
_FREE = CFUNCTYPE(None, c_void_p)
_FINISHED = CFUNCTYPE(None, c_void_p, c_int)


class Callbacks2(ctypes.Structure):
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
        memory = _ALLOCATE(self._allocate), _FREE(self._free)
        self.functions = Callbacks2(self.logger2, *memory, _FINISHED(), self.environment)

    def _log2(self, place: int | None, _: bytes, status: int, *rest: Any) -> None:
        if len(self.messages) < MOST_MESSAGES:
            category, text, *arguments = rest
            if text is not None:
                known = ((v.kind, v.reference, v.name) for v in self.variables)
                text = named(_word(formatted(text, arguments)) or "", known).encode()
            self._log3(place, status, category, text)

    def _log3(self, place: int | None, status: int, kind: bytes | None, text: bytes | None) -> None:
        if len(self.messages) < MOST_MESSAGES:
            self.messages.append(Message(status, _word(kind), _word(text), place))

    def _allocate(self, count: int, size: int) -> int | None:
        self.allocated += 1
        found: int | None = _LIBC.calloc(count, size)
        return found

    def _free(self, memory: int | None) -> None:
        _LIBC.free(memory)
