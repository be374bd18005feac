"""Locks on open files: they die with their process, however it ends."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import IO, Any


def lock(file: IO[Any]) -> bool:
    """Lock an open file until it is closed; return False if someone else has it.

    OSError where the file system knows no locks.
    """
    if sys.platform == "win32":
        import msvcrt

        position = file.tell()
        file.seek(2**30)  # a lock on bytes that exist would keep others from reading them
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        finally:
            file.seek(position)
        return True
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def is_at(file: IO[Any], path: Path) -> bool:
    """Return whether an open file still is the one of that name."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.lstat())
    except FileNotFoundError:
        return False
