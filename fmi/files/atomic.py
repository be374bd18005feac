"""How a file appears whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO
from uuid import uuid4

from stickslip.fmi.files.lock import is_at, lock

_TEMPORARY = re.compile(r"\.stickslip-[0-9a-f]{32}")


def atomic_write(path: Path, content: bytes | str) -> Path:
    """Write a file so that a reader sees the old one or the new one, never a part of it.

    Text is written as UTF-8. The folder is made if it is absent. What killed processes left in it
    half-written is deleted.

    Raises
    ------
    OSError
        When there is a link or no plain file of that name, the folder cannot be written or the disk
        is full; ``path`` is then as it was. The error names ``path``.
    """
    data = content.encode() if isinstance(content, str) else content
    require_regular_file(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    _sweep(path.parent)
    try:
        with _beside(path.parent) as (file, temporary):
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
            if sys.platform == "win32":
                file.close()  # there an open file cannot be renamed
            temporary.replace(path)
        sync_folder(path.parent)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from fault
    return path


def require_regular_file(path: Path) -> None:
    """Raise OSError where there is a link, a folder or a device of that name."""
    try:
        mode = path.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return
    if stat.S_ISLNK(mode):
        raise OSError(errno.ELOOP, "is a symbolic link, expected a plain file", str(path))
    if not stat.S_ISREG(mode):
        said = f"is a {'folder' if stat.S_ISDIR(mode) else 'device'}, expected a plain file"
        raise OSError(errno.EISDIR, said, str(path))


def sync_folder(folder: Path) -> None:
    """Have the names in a folder on the disk, where the system knows how."""
    if sys.platform == "win32":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def _beside(folder: Path) -> Iterator[tuple[BinaryIO, Path]]:
    """Open a new file, locked as long as it is open; it is gone at the end unless renamed."""
    while True:
        temporary = folder / f".stickslip-{uuid4().hex}"
        with temporary.open("xb") as file:
            try:
                with suppress(OSError):  # without locks nobody will sweep it either
                    lock(file)
                if is_at(file, temporary):  # else it was swept before it was locked
                    yield file, temporary
                    return
            finally:
                if sys.platform == "win32":
                    file.close()
                temporary.unlink(missing_ok=True)


def _sweep(folder: Path) -> None:
    """Delete temporary files whose processes are gone: nobody has them locked."""
    with os.scandir(folder) as entries:  # a cache has thousands
        temporary = [Path(entry) for entry in entries if _TEMPORARY.fullmatch(entry.name)]
    for path in temporary:
        with suppress(OSError):
            if stat.S_ISREG(path.lstat().st_mode):
                with path.open("rb") as file:
                    swept = lock(file)
                    if swept and sys.platform != "win32":
                        path.unlink()
                if swept:
                    path.unlink(missing_ok=True)
