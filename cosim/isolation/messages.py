"""What passes between parent and child, and the error when the child died."""

from __future__ import annotations

import copyreg
import ctypes
import io
import json
import math
import mmap
import os
import pickle
import select
import signal
import struct
import sys
import tempfile
import threading
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from queue import Empty, SimpleQueue
from types import MappingProxyType
from typing import Any, Self
from uuid import uuid4

import numpy as np

from stickslip.cosim.errors import FmuCrashed
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.kernel import structures
from stickslip.cosim.kernel.structures import Mark
from stickslip.cosim.signals.signals import Array, Input, sampled
from stickslip.cosim.system.system import Specification, System

TOKEN_SIZE = 16  # bytes of the random token by which parent and child know each other's messages
_HEAD = struct.Struct(f"<{TOKEN_SIZE}sQL")  # before each message: token, length, CRC-32
LOST = 113  # exit status of a child that cannot reach its parent
_LONGEST = 2**26  # bytes of an answer
_PART = 2**16  # bytes read at once
Reply = dict[str, Any]
NONSENSE: Reply = {"error": "nonsense"}
"""Stands for bytes that are not an answer of the child, such as an FMU writes into the pipe."""


class Answers:
    """The parent's ends of both pipes, where bytes without the token are no answer.

    Nothing here blocks for longer than a given time.
    """

    def __init__(self, requests: int, replies: int, token: bytes) -> None:
        self._requests, self._replies, self._token = requests, replies, token
        self._unsent = memoryview(b"")
        self._received = bytearray()
        self._begun = False  # whether there was a message
        self._open()

    def _open(self) -> None:
        os.set_blocking(self._requests, False)
        self._poll = select.poll()
        self._poll.register(self._replies, select.POLLIN)

    def send(self, request: bytes) -> None:
        """Begin to send a request; the rest goes while its answer is awaited."""
        self._unsent = memoryview(message(self._token, request))
        self._poll.register(self._requests, select.POLLOUT)

    def get(self, timeout: float) -> Reply | None:
        """Return the next answer, None at the end of the pipe."""
        end = time.monotonic() + timeout
        while (reply := self._taken()) is None:
            part = self._part(end)
            if not part:
                return None
            self._received += part
        return reply

    def _part(self, end: float) -> bytes:
        """Return the bytes that come next, none at the end of the file."""
        while ready := self._poll.poll(1000.0 * max(0.0, end - time.monotonic())):
            if any(file == self._replies for file, _ in ready):
                return _read_part(self._replies)
            self._send_more()
        raise Empty

    def _send_more(self) -> None:
        try:
            self._unsent = self._unsent[os.write(self._requests, self._unsent) :]
        except OSError:  # the child is dead, which is noticed on waiting for its answer
            self._unsent = memoryview(b"")
        if not self._unsent:
            self._poll.unregister(self._requests)

    def _taken(self) -> Reply | None:
        """Take the first answer out of what was received; None where it is not whole yet."""
        received = self._received
        if not self._begun:  # Python may print as it starts, by a sitecustomize
            place = received.find(self._token)
            self._begun = place >= 0
            del received[: place if self._begun else 1 - TOKEN_SIZE]
            if not self._begun:
                return None
        if received[:TOKEN_SIZE] != self._token[: len(received)]:
            return NONSENSE
        if len(received) < _HEAD.size:
            return None
        _, length, check = _HEAD.unpack_from(received)
        if length > _LONGEST:
            return NONSENSE
        end = _HEAD.size + length
        if len(received) < end:
            return None
        content = bytes(received[_HEAD.size : end])
        del received[:end]
        with suppress(ValueError, RecursionError):
            reply = json.loads(content)
            if zlib.crc32(content) == check and isinstance(reply, dict):
                return reply
        return NONSENSE


class ThreadedAnswers(Answers):
    """The same by threads, for systems that cannot poll a pipe."""

    def _open(self) -> None:
        self._parts: SimpleQueue[bytes] = SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()

    def send(self, request: bytes) -> None:
        """Send a request, see Answers."""
        threading.Thread(target=self._write, args=(request,), daemon=True).start()

    def _write(self, request: bytes) -> None:
        with suppress(OSError):
            send(self._requests, self._token, request)

    def _part(self, end: float) -> bytes:
        return self._parts.get(timeout=max(0.0, end - time.monotonic()))

    def _listen(self) -> None:
        while part := _read_part(self._replies):
            self._parts.put(part)
        self._parts.put(b"")


def message(token: bytes, content: bytes) -> bytes:
    """Return content after a header of token, length and CRC-32."""
    return _HEAD.pack(token, len(content), zlib.crc32(content)) + content


def send(file: int, token: bytes, content: bytes) -> None:
    """Write a message, however long that takes."""
    rest = memoryview(message(token, content))
    while rest:
        rest = rest[os.write(file, rest) :]


def receive(file: int, token: bytes) -> bytes:
    """Return the content of the next message, however long that takes."""
    head = _read(file, _HEAD.size)
    if len(head) == _HEAD.size:
        found, length, check = _HEAD.unpack(head)
        if found == token:
            content = _read(file, length)
            if len(content) == length and zlib.crc32(content) == check:
                return content
    raise OSError("expected a message")


def _read(file: int, n: int) -> bytes:
    """Return n bytes; fewer at the end of the file."""
    parts = []
    while n and (part := os.read(file, min(n, 2**20))):
        parts.append(part)
        n -= len(part)
    return b"".join(parts)


def _read_part(file: int) -> bytes:
    try:
        return os.read(file, _PART)
    except OSError:
        return b""


_SHRINK, _FUTURE_WRITE = 0x2, 0x10  # seals of Linux: to make it shorter, to write by calls
_BEGIN = 4096  # bytes of the mark, before the results


class Shared:
    """A mark, and numbers (n,); ``files`` are those that the child must inherit."""

    def __init__(self, memory: mmap.mmap, name: str, files: tuple[int, ...] = ()) -> None:
        self.mark = Mark.from_buffer(memory)
        self.numbers: Array = np.frombuffer(memory, np.float64, offset=_BEGIN)
        self.name, self.size, self.files = name, len(memory), files

    @classmethod
    def open(cls, name: str, size: int) -> Self:
        """Map the memory of the parent by its name; processes that fork do not inherit it."""
        if sys.platform == "win32":
            return cls(mmap.mmap(-1, size, tagname=name), name)
        memory = mmap.mmap(int(name), size)
        _seal(int(name), _FUTURE_WRITE)
        os.close(int(name))
        if hasattr(mmap, "MADV_DONTFORK"):
            memory.madvise(mmap.MADV_DONTFORK)
        return cls(memory, name)

    @classmethod
    def make(cls, n: int) -> Self:
        """Make memory for n numbers, which is freed when the last process unmaps it."""
        size = _BEGIN + 8 * max(1, n)
        if sys.platform == "win32":
            name = f"stickslip-{uuid4().hex}"
            return cls(mmap.mmap(-1, size, tagname=name), name)
        file = _file(size)
        return cls(mmap.mmap(file, size), str(file), (file,))

    def close_files(self) -> None:
        """Close what the child has inherited."""
        while self.files:
            os.close(self.files[0])
            self.files = self.files[1:]


def _file(size: int) -> int:
    """Return a file without a name; on Linux it cannot be truncated."""
    import fcntl

    if hasattr(os, "memfd_create"):
        first = os.memfd_create("stickslip", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    else:
        with tempfile.TemporaryFile() as file:
            first = os.dup(file.fileno())
    place = fcntl.fcntl(first, fcntl.F_DUPFD_CLOEXEC, 3)  # no number of a standard stream
    os.close(first)
    os.ftruncate(place, size)
    _seal(place, _SHRINK)
    return place


def _seal(file: int, seal: int) -> None:
    """Forbid something for good, where the system can do that."""
    import fcntl

    with suppress(AttributeError, OSError):
        fcntl.fcntl(file, fcntl.F_ADD_SEALS, seal)


class _Packer(pickle.Pickler):
    """Takes FMUs as they are, where a plain pickle is their path."""

    def reducer_override(self, thing: object) -> Any:
        if isinstance(thing, Fmu):
            return copyreg.__newobj__, (Fmu,), thing.__dict__  # type: ignore[attr-defined]
        if isinstance(thing, MappingProxyType):
            return _unchanging, (dict(thing),)
        return NotImplemented


def _unchanging(content: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(content)


def pack(specification: Specification, **more: object) -> bytes:
    """Return a specification, and what goes with it, as bytes for ``pickle``."""
    system = specification.system.copy()
    system.origin = None
    stream = io.BytesIO()
    plain = replace(specification, system=system, isolation=None)
    _Packer(stream, pickle.HIGHEST_PROTOCOL).dump({"specification": plain, **more})
    return stream.getvalue()


def portable_inputs(inputs: Mapping[str, Input], time: Callable[[], Array]) -> dict[str, Input]:
    """Return inputs that another process understands: our signals as they are, others sampled."""
    return {name: _portable(name, signal, time) for name, signal in inputs.items()}


def _portable(name: str, signal: Input, time: Callable[[], Array]) -> Input:
    ours = type(signal).__module__ == "stickslip.cosim.signals.signals"
    plain = isinstance(signal, int | float | np.ndarray)
    return signal if ours or plain else sampled(name, signal, time())


_UNTIMED = ("load", "unload", "Instantiate", "FreeInstance")  # calls at no simulated time


def ending(status: int | None, memory: float | None = None) -> str:
    """Describe an exit status, None if unreachable; ``memory`` (MB) is a limit that was near."""
    if status is None or status == LOST:
        return "or a call before it closed files that are not its own"
    if status >= 0:
        return f"ended its process with status {status}"
    limit = f" (it may take {memory:g} MB of memory)" if memory else ""
    known = -status in set(signal.Signals)
    return f"died of {signal.Signals(-status).name if known else f'signal {-status}'}{limit}"


def crashed(
    mark: Mark,
    system: System,
    order: Sequence[str],
    what: str,
    printed: str = "",
    denied: Sequence[str] = (),
) -> FmuCrashed:
    """Return the error: what happened in the call of the mark, what was printed and denied."""
    call = mark.call.decode(errors="replace") or "its process"
    when = ""
    if not any(word in call for word in _UNTIMED):
        when = f" at t = {mark.t:.9g} s" if math.isfinite(mark.t) else " during initialisation"
    printed = f"; it printed: {printed}" if printed else ""
    said = f"{what}{when}{printed}{'; '.join(['', *denied])}"
    return FmuCrashed(f"{present(mark, system, order)} {said}")


def present(mark: Mark, system: System, order: Sequence[str]) -> str:
    """Return the component and the call it is in, such as ``drive (drive.fmu): fmi2DoStep``."""
    call = mark.call.decode(errors="replace") or "its process"
    name = called(mark, order) or mark.name.decode(errors="replace")
    if name in system.components:
        name = f"{name} ({system.components[name].label})"
    name = name or ", ".join(sorted({fmu.label for fmu in system.components.values()}))
    return f"{name}: {call}"


def called(mark: Mark, order: Sequence[str]) -> str | None:
    """Return the component that was called, None where the kernel called none."""
    if not (mark.component and mark.first):
        return None
    place, rest = divmod(mark.component - mark.first, ctypes.sizeof(structures.Component))
    return None if rest or not 0 <= place < len(order) else order[place]
