"""Messages between parent and child, sent and awaited for a limited time."""

from __future__ import annotations

import json
import os
import select
import struct
import threading
import time
import zlib
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

TOKEN_SIZE = 16
"""Bytes of the random token by which parent and child know each other's messages."""

_HEAD = struct.Struct(f"<{TOKEN_SIZE}sQL")  # before each message: token, length, CRC-32

LOST = 113
"""Exit status of a child that cannot reach its parent."""

_LONGEST = 2**26  # bytes of an answer
_PART = 2**16  # bytes read at once

Reply = dict[str, Any]

NONSENSE: Reply = {"error": "nonsense"}
"""Stands for bytes that are not an answer of the child, such as an FMU writes into the pipe."""


class Answers:
    """The parent's ends of both pipes. Nothing here blocks for longer than a given time.

    Parameters
    ----------
    requests, replies : file descriptors, for writing and for reading
    token : of the child; bytes without it are not an answer
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
        """Return the next answer, None at the end of the pipe.

        Raises
        ------
        queue.Empty
            When no complete answer arrived within ``timeout`` (s).
        """
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
    """Write a message, however long that takes.

    Raises
    ------
    OSError
        When the other end is closed.
    """
    rest = memoryview(message(token, content))
    while rest:
        rest = rest[os.write(file, rest) :]


def receive(file: int, token: bytes) -> bytes:
    """Return the content of the next message, however long that takes.

    Raises
    ------
    OSError
        When the pipe ends, or holds something else.
    """
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
