"""Answers of the child, awaited for a limited time."""

from __future__ import annotations

import json
import os
import select
import struct
import sys
import threading
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import IO, Any

HEAD = struct.Struct("<Q")
"""Before each message: its length."""

LOST = 113
"""Exit status of a child that cannot reach its parent."""

_LONGEST = 2**20  # bytes of an answer

Reply = dict[str, Any]

NONSENSE: Reply = {"error": "nonsense"}
"""What stands for an answer that is none."""


class Answers:
    """The reading end of a pipe.

    Parameters
    ----------
    pipe : without a buffer
    """

    def __init__(self, pipe: IO[bytes]) -> None:
        self._pipe = pipe
        if sys.platform != "win32":
            self._poll = select.poll()
            self._poll.register(pipe, select.POLLIN)

    def get(self, timeout: float) -> Reply | None:
        """Return the next answer, None when there will be no more.

        Raises
        ------
        queue.Empty
            When none came within ``timeout`` (s).
        """
        if not self._poll.poll(1000.0 * timeout):
            raise Empty
        return self._read()

    def _read(self) -> Reply | None:
        with suppress(OSError, ValueError, struct.error):
            head = read(self._pipe.fileno(), HEAD.size)
            if not head:
                return None
            (length,) = HEAD.unpack(head)
            if length <= _LONGEST:
                reply = json.loads(read(self._pipe.fileno(), length))
                return reply if isinstance(reply, dict) else NONSENSE
        return NONSENSE


class HeardAnswers(Answers):
    """The same by a thread, for systems that cannot wait for a pipe."""

    def __init__(self, pipe: IO[bytes]) -> None:
        super().__init__(pipe)
        self._heard: SimpleQueue[Reply | None] = SimpleQueue()
        threading.Thread(target=self._hear, daemon=True).start()

    def get(self, timeout: float) -> Reply | None:
        """Return the next answer, see Answers."""
        return self._heard.get(timeout=timeout)

    def _hear(self) -> None:
        while (reply := self._read()) is not None:
            self._heard.put(reply)
        self._heard.put(None)


def read(file: int, n: int) -> bytes:
    """Return n bytes; fewer at the end of the file."""
    parts = []
    while n and (part := os.read(file, min(n, 2**20))):
        parts.append(part)
        n -= len(part)
    return b"".join(parts)


def send(file: int, message: bytes) -> None:
    """Write a message behind its length.

    Raises
    ------
    OSError
        When nobody reads.
    """
    rest = memoryview(HEAD.pack(len(message)) + message)
    while rest:
        rest = rest[os.write(file, rest) :]
