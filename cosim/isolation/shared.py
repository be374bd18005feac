"""Memory shared by parent and child: the mark of the present call, and results."""

from __future__ import annotations

import mmap
import os
import sys
import tempfile
from contextlib import suppress
from typing import Self
from uuid import uuid4

import numpy as np

from stickslip.cosim.kernel.structures import Mark
from stickslip.cosim.signals.signals import Array

_SHRINK, _FUTURE_WRITE = 0x2, 0x10  # seals of Linux: to make it shorter, to write by calls
_BEGIN = 4096  # bytes of the mark, before the results


class Shared:
    """A mark, and room for numbers.

    Attributes
    ----------
    mark : which call an FMU is in
    numbers : (n,) float64
    name, size : by which a child maps the memory; in bytes
    files : that the child must inherit, to be closed afterwards
    """

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
