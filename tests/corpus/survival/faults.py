"""What goes wrong at the n-th thing that is asked of the file system."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT
CHANGES = {"os.rename", "os.mkdir"}
"""Events that may need room on the disk, beside files opened to write and those synced."""
DELETIONS = {"os.remove", "os.rmdir"}


class _Fault:
    """Counts what is asked of the file system below a folder and acts at the n-th time."""

    def __init__(self) -> None:
        self.folder, self.act, self.n, self.counted = "", None, 0, 0
        self.deletions = True
        sys.addaudithook(self._hear)
        sync = os.fsync

        def synced(handle: int) -> None:
            self.count()
            sync(handle)

        os.fsync = synced

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self.folder:
            return
        asked = (
            (event == "open" and arguments[2] & WRITES)
            or event in CHANGES
            or (self.deletions and event in DELETIONS)
        )
        if asked and os.fspath(arguments[0]).startswith(self.folder):
            self.count()

    def count(self) -> None:
        if self.folder:
            self.counted += 1
            if self.act and self.counted >= self.n:
                self.act()


_fault: list[_Fault] = []


@contextmanager
def fault(
    folder: Path, act: Callable[[], object] | None = None, n: int = 0, *, deletions: bool = True
) -> Iterator[_Fault]:
    """Call ``act`` before the n-th operation in a folder and each after it; None only counts.

    Parameters
    ----------
    deletions : whether they count
    """
    if not _fault:
        _fault.append(_Fault())
    (it,) = _fault
    it.act, it.n, it.counted, it.deletions, it.folder = act, n, 0, deletions, str(folder)
    try:
        yield it
    finally:
        it.folder = ""


def die() -> None:
    """End this process as the system does that has no memory left."""
    os.kill(os.getpid(), 9)


def full() -> NoReturn:
    """Have no room on the disk."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def once(act: Callable[[], object]) -> Callable[[], object]:
    """Return what acts the first time only."""
    left = [act]
    return lambda: left.pop()() if left else None
