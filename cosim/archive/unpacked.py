"""The cache of unpacked archives: folders named by content, whole, mended and tidied."""

from __future__ import annotations

import hashlib
import json
import shutil
import stat
import tempfile
import time
from pathlib import Path
from typing import IO

import toolchain
from cosim.archive.errors import Refused
from cosim.archive.members import extract
from cosim.errors import CosimError

_STALE = 3600.0  # s after which a half-unpacked folder belongs to a process that was killed
_UNUSED = 90 * 86400.0  # s after which a folder that nobody opened goes
_NOTED = 86400.0  # s after which it is noted that a folder is used
_PARTIAL = ".unpack-"


def unpack(path: Path, room: str, error: type[CosimError]) -> Path:
    """Unpack an archive to ``<cache>/<room>/<sha256 of the file>`` and return that folder.

    The folder appears whole or not at all. While its files have the sizes they had, which a list
    beside it holds, the archive is not opened again.

    Raises
    ------
    error
        When the file cannot be read, is no zip archive, or holds members that are not safe.
    """
    try:
        return _unpacked(path, room)
    except Refused as fault:
        raise error(f"{path}: {fault}") from fault
    except OSError as fault:
        where = f" ({fault.filename})" if fault.filename not in (None, str(path)) else ""
        raise error(f"{path}: cannot be unpacked{where}: {fault.strerror}") from fault


def _unpacked(path: Path, room: str) -> Path:
    if not stat.S_ISREG(path.stat().st_mode):
        raise Refused("is no file; an archive is expected")
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        folder = toolchain.cache_directory() / room / digest
        if not _is_whole(folder):
            folder.parent.mkdir(parents=True, exist_ok=True)
            _tidy(folder.parent)
            _unpack_new(file, folder)
    return folder


def _list(folder: Path) -> Path:
    return folder.with_suffix(".json")


def _is_whole(folder: Path) -> bool:
    """Return whether every file is there in its size; note that the folder is used."""
    listed = _list(folder)
    try:
        sizes = json.loads(listed.read_bytes())
        whole = folder.is_dir() and all((folder / n).stat().st_size == sizes[n] for n in sizes)
        if whole and time.time() - listed.stat().st_mtime > _NOTED:
            listed.touch()
    except (OSError, ValueError, TypeError):
        return False
    return whole


def _unpack_new(file: IO[bytes], folder: Path) -> None:
    temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=_PARTIAL))
    try:
        sizes = extract(file, temporary / "new")
        toolchain.write_whole(_list(folder), json.dumps(sizes))
        _replace(temporary / "new", folder)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _replace(new: Path, folder: Path) -> None:
    """Put a folder in the place of one that is damaged, or that another process just made."""
    try:
        new.replace(folder)
    except OSError:
        if _is_whole(folder):
            return
        folder.replace(new.with_name("old"))
        new.replace(folder)


def _tidy(room: Path) -> None:
    """Remove what killed processes left, and what has not been used for months."""
    now = time.time()
    for partial in room.glob(f"{_PARTIAL}*"):
        if _age(partial, now) > _STALE:
            shutil.rmtree(partial, ignore_errors=True)
    for listed in room.glob("*.json"):
        if _age(listed, now) > _UNUSED:
            shutil.rmtree(listed.with_suffix(""), ignore_errors=True)
            listed.unlink(missing_ok=True)


def _age(path: Path, now: float) -> float:
    try:
        return now - path.stat().st_mtime
    except OSError:  # another process was faster
        return 0.0
