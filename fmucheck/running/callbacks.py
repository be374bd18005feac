"""What an FMU may call back: the logger and, in FMI 2.0, memory."""

from __future__ import annotations

import ctypes
import sys
from ctypes import CFUNCTYPE, Structure, c_char_p, c_int, c_size_t, c_void_p
from dataclasses import dataclass, field

_LIBC = ctypes.CDLL("msvcrt" if sys.platform == "win32" else None)
_LIBC.calloc.restype = c_void_p
_LIBC.calloc.argtypes = (c_size_t, c_size_t)
_LIBC.free.argtypes = (c_void_p,)

MOST_MESSAGES = 10_000  # kept of one instance
LOGGER2 = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
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
        self, place: int | None, _: bytes, status: int, category: bytes | None, text: bytes | None
    ) -> None:
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
