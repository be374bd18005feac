"""Who may write into a folder of results: one process at a time."""

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import IO

from stickslip.errors import UsageError
from stickslip.fmi.files import is_at, lock, require_regular_file

PREFIX = ".stickslip-"  # Of the names of temporary files and folders
WRITING = f"{PREFIX}writing-"
_LOCK = f"{PREFIX}lock"

_held: ContextVar[Mapping[Path, IO[str]]] = ContextVar("_held")


@contextmanager
def locked(folder: Path | None) -> Iterator[None]:
    """Make a folder and lock it for this process; nested blocks of one process share the lock.

    Staging folders of killed processes are deleted, and at the end a folder that was made here and
    is empty. None locks nothing. Raises UsageError when it cannot be made or written, or another
    process has locked it.
    """
    if folder is None or is_locked(folder):
        yield
        return
    place = folder.resolve()
    with writable(folder):
        file = _lock(folder, place / _LOCK)
        token = _held.set({**_held.get({}), place: file})
        try:
            for left in place.glob(f"{WRITING}*"):
                shutil.rmtree(left, ignore_errors=True)
            yield
        finally:
            _held.reset(token)
            _release(file, place / _LOCK)


def is_locked(folder: Path) -> bool:
    """Return whether this process has locked a folder, which still is the same one."""
    place = folder.resolve()
    file = _held.get({}).get(place)
    return file is not None and is_at(file, place / _LOCK)


@contextmanager
def writable(folder: Path) -> Iterator[None]:
    """Make a folder and try to write there, or raise UsageError; delete it if still empty."""
    made = [path for path in (folder, *folder.parents) if not os.path.lexists(path)]
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder) as file:
                file.write(b"x")
        except OSError as error:
            raise UsageError(
                f"{folder}: cannot write there ({error.strerror}); choose another <out>"
            ) from None
        yield
    finally:
        for path in made:
            with suppress(OSError):
                path.rmdir()


def _lock(folder: Path, path: Path) -> IO[str]:
    while True:
        require_regular_file(path)
        file = path.open("a+", encoding="utf-8")
        try:
            free = lock(file)
        except OSError:
            free = True  # a file system without locks
        if not free:
            with file:
                file.seek(0)
                owner = file.read(20).strip()
            raise UsageError(
                f"{folder}: process {owner if owner.isdigit() else 'unknown'} is writing there; "
                "wait until it has ended, or choose another <out>"
            )
        if is_at(file, path):  # else its owner has just ended and deleted it
            file.truncate(0)
            file.write(f"{os.getpid()}\n")
            file.flush()
            return file
        file.close()


def _release(file: IO[str], path: Path) -> None:
    ours = is_at(file, path)  # else the folder was removed, and may be another process's now
    if sys.platform == "win32":
        file.close()  # there an open file cannot be deleted
    if ours:
        with suppress(OSError):
            path.unlink()
    file.close()
