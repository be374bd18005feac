"""Memory that parent and child both see: the mark of the present call, and results."""

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
_BEGIN = 4096  # bytes before the results; the mark lies there


class Shared:
    """A mark, and room for numbers.

    Parameters
    ----------
    memory : mapped

    Attributes
    ----------
    mark : which call an FMU is in
    numbers : (n,) float64
    """

    def __init__(self, memory: mmap.mmap) -> None:
        self.mark = Mark.from_buffer(memory)
        self.numbers: Array = np.frombuffer(memory, np.float64, offset=_BEGIN)

    @classmethod
    def open(cls, name: str, size: int) -> Self:
        """Map the memory of the parent by its name; processes that fork do not inherit it."""
        if sys.platform == "win32":
            return cls(mmap.mmap(-1, size, tagname=name))
        memory = mmap.mmap(int(name), size)
        _seal(int(name), _FUTURE_WRITE)
        os.close(int(name))
        if hasattr(mmap, "MADV_DONTFORK"):
            memory.madvise(mmap.MADV_DONTFORK)
        return cls(memory)


class Made:
    """Shared memory that is made here; it is gone when the last process lets go.

    Parameters
    ----------
    n : how many numbers it has room for

    Attributes
    ----------
    shared : the memory
    name : by which a child finds it
    size : bytes
    files : that the child must inherit; to be closed when it has
    """

    def __init__(self, n: int) -> None:
        self.size = _BEGIN + 8 * max(1, n)
        self.files: tuple[int, ...] = ()
        if sys.platform == "win32":
            self.name = f"stickslip-{uuid4().hex}"
            memory = mmap.mmap(-1, self.size, tagname=self.name)
        else:
            self.files = (_file(self.size),)
            self.name = str(self.files[0])
            memory = mmap.mmap(self.files[0], self.size)
        self.shared = Shared(memory)

    def close_files(self) -> None:
        """Close what the child has inherited."""
        while self.files:
            os.close(self.files[0])
            self.files = self.files[1:]


def _file(size: int) -> int:
    """Return a file without a name, as large as that; on Linux it cannot be truncated."""
    if hasattr(os, "memfd_create"):
        place = os.memfd_create("stickslip", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    else:
        with tempfile.TemporaryFile() as file:
            place = os.dup(file.fileno())
    place = _beyond_standard(place)
    os.ftruncate(place, size)
    _seal(place, _SHRINK)
    return place


def _beyond_standard(file: int) -> int:
    """Return an open file under a number that no standard stream has, even if those are closed."""
    if file > 2:
        return file
    import fcntl

    try:
        return fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, 3)
    finally:
        os.close(file)


def _seal(file: int, seal: int) -> None:
    """Forbid something for good, where the system can do that."""
    import fcntl

    with suppress(AttributeError, OSError):
        fcntl.fcntl(file, fcntl.F_ADD_SEALS, seal)
