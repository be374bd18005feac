"""Who may write into a folder of results: one process at a time."""

from __future__ import annotations

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

OURS = ".stickslip-"
"""How the names begin of what is ours alone in a folder, and there only while it is written."""
WRITING = f"{OURS}writing-"
_LOCK = f"{OURS}lock"

_held: ContextVar[Mapping[Path, IO[str]]] = ContextVar("_held")


@contextmanager
def locked(folder: Path | None) -> Iterator[None]:
    """Make a folder and have it for this process alone; nested blocks of one process are one claim.

    What killed processes left half-written is deleted. A folder that was made here and is still
    empty at the end goes. None is no folder, and nothing is locked.

    Raises
    ------
    UsageError
        When it cannot be made or written, or another process has it.
    """
    if folder is None:
        yield
        return
    place, held = folder.resolve(), _held.get({})
    if place in held and is_at(held[place], place / _LOCK):
        yield
        return
    with writable(folder):
        file = _lock(folder, place / _LOCK)
        token = _held.set({**held, place: file})
        try:
            for left in place.glob(f"{WRITING}*"):
                shutil.rmtree(left, ignore_errors=True)
            yield
        finally:
            _held.reset(token)
            _release(file, place / _LOCK)


@contextmanager
def writable(folder: Path) -> Iterator[None]:
    """Make a folder and try to write there; what was made and is empty at the end goes.

    Raises
    ------
    UsageError
        When that is not possible.
    """
    made = [path for path in (folder, *folder.parents) if not os.path.lexists(path)]
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder) as file:
                file.write(b"x")
        except OSError as error:
            raise UsageError(
                f"{folder}: cannot write there ({error.strerror}); choose another folder with --out"
            ) from None
        yield
    finally:
        for path in made:
            with suppress(OSError):
                path.rmdir()


def _lock(folder: Path, path: Path) -> IO[str]:
    while True:
        file = _open(path)
        try:
            _refuse_other(folder, file)
            if is_at(file, path):  # else its owner has just ended and deleted it
                file.truncate(0)
                file.write(f"{os.getpid()}\n")
                file.flush()
                return file
        except BaseException:
            file.close()
            raise
        file.close()


def _open(path: Path) -> IO[str]:
    """Open the file of the lock, which may be there from a process that was killed."""
    require_regular_file(path)
    return path.open("a+", encoding="utf-8")


def _refuse_other(folder: Path, file: IO[str]) -> None:
    try:
        if lock(file):
            return
    except OSError:
        return  # a file system without locks must do without
    file.seek(0)
    owner = file.read(20).strip()
    raise UsageError(
        f"{folder}: process {owner if owner.isdigit() else 'unknown'} is writing there; wait until "
        "it has ended, or choose another folder with --out"
    )


def _release(file: IO[str], path: Path) -> None:
    if sys.platform == "win32":
        file.close()  # there an open file cannot be deleted
    elif not is_at(file, path):
        path = path.with_name(f"{OURS}none")  # the folder was removed, and may be another's now
    with suppress(OSError):
        path.unlink()
    file.close()
