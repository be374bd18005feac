"""The cache of unpacked archives: folders named by content, whole, mended and tidied.

The bytes that come out of a member are counted, whatever the headers say.
"""

import errno
import hashlib
import json
import os
import shutil
import stat
import tempfile
import time
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO

from stickslip.fmi import toolchain
from stickslip.fmi.archive import directory
from stickslip.fmi.archive.directory import Refused, check_frame
from stickslip.fmi.errors import Fault
from stickslip.fmi.files import atomic_write, require_regular_file
from stickslip.fmi.messages import printable, shown

_CHUNK = 1024**2
# All that zipfile and zlib raise for what is in a file: RuntimeError for encrypted members,
# NotImplementedError for methods, ValueError for impossible offsets and names.
FAULTS = (zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError, OverflowError)


def extract(file: IO[bytes], folder: Path) -> dict[str, int]:
    """Unpack an archive into a new folder; return the CRC-32 of each file by its path."""
    try:
        stated = check_frame(file)
    except ValueError as fault:
        raise Refused(str(fault)) from None
    with _blaming("not a zip archive, or a damaged one"):
        archive = zipfile.ZipFile(file)
    with archive:
        members = archive.infolist()
        placed = directory.check_members(members, stated)
        total = sum(member.file_size for member in members)
        if total > (free := shutil.disk_usage(folder.parent).free):
            what = f"{total} bytes, but only {free} are free"
            raise OSError(errno.ENOSPC, what, str(folder.parent))
        folder.mkdir()
        checks: dict[str, int] = {}
        for path, member in placed:
            target = folder / path
            if directory.is_folder(member):
                target.mkdir(parents=True, exist_ok=True)
            else:
                target.parent.mkdir(parents=True, exist_ok=True)
                extract_file(archive, member, target)
                checks[str(path)] = member.CRC
        return checks


def extract_file(archive: zipfile.ZipFile, member: zipfile.ZipInfo, target: Path) -> None:
    """Write one file, not a byte more than its header declares."""
    what, size = f"member {shown(member.orig_filename)} is damaged", 0
    with _blaming(what), archive.open(member) as source, target.open("xb") as copy:
        while chunk := source.read(_CHUNK):
            size += len(chunk)
            if size > member.file_size:
                break
            copy.write(chunk)
    if size != member.file_size:
        fault = f"{size} bytes, expected {member.file_size} as its header says"
        raise Refused(f"{what}: {fault}; copy or export the archive again")


@contextmanager
def _blaming(what: str) -> Iterator[None]:
    try:
        yield
    except FAULTS as fault:
        raise Refused(f"{what}: {printable(str(fault))}; copy or export it again") from fault


_STALE = 3600.0  # s after which a half-unpacked folder belongs to a process that was killed
_UNUSED = 90 * 86400.0  # s after which a folder that nobody opened goes
_NOTED = 86400.0  # s after which it is noted that a folder is used
_PARTIAL = ".unpack-"


def unpack(path: Path, room: str, error: type[Fault]) -> Path:
    """Unpack an archive to ``<cache>/<room>/<sha256 of the file>`` and return that folder.

    The folder appears whole or not at all. A list beside it holds what its files were. As long as
    they are that, the archive is not opened again; a folder in which something was changed, added
    or removed, as an FMU can do, is replaced. ``error`` when the file cannot be read, is no zip
    archive, or holds members that are not safe.
    """
    try:
        return _unpacked(path, room)
    except Refused as fault:
        raise error(f"{path}: {fault}") from fault
    except OSError as fault:
        if fault.filename == str(path):
            raise error(f"{path}: {fault.strerror}") from fault
        where, advice = f" ({fault.filename})", f"; {toolchain.CACHE_ADVICE}"
        raise error(f"{path}: cannot be unpacked{where}: {fault.strerror}{advice}") from fault


def restore(folder: Path, path: Path, error: type[Fault]) -> None:
    """Unpack an archive again where its folder was changed; ``error`` where that is impossible."""
    if not _is_whole(folder) and unpack(path, folder.parent.name, error) != folder:
        what = "its unpacked files were changed, and so was the archive itself since it was read"
        raise error(f"{path}: {what}; read it again")


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


def _is_whole(folder: Path) -> bool:
    """Return whether the files are those that were unpacked; note that the folder is used."""
    listed = folder.with_suffix(".json")
    try:
        unpacked = json.loads(listed.read_bytes())
        found = _files(folder)
        if found.keys() != unpacked.keys():
            return False
        now = {name: [*file, unpacked[name][-1]] for name, file in found.items()}
        odd = [name for name in now if now[name] != unpacked[name]]
        if any(_check(folder / name) != unpacked[name][-1] for name in odd):
            return False
    except (OSError, ValueError, TypeError, LookupError, AttributeError):
        return False
    with suppress(OSError):  # others may own the cache
        if odd:  # it was copied, say, with the same content
            atomic_write(listed, json.dumps(now))
        elif time.time() - listed.stat().st_mtime > _NOTED:
            listed.touch()
    return True


def _files(folder: Path) -> dict[str, list[int]]:
    """Return size and what changes with any change of content, of all that is no folder."""
    found = {}
    waiting = [""]
    while waiting:
        below = waiting.pop()
        with os.scandir(folder / below) as entries:
            for entry in entries:
                name = f"{below}{entry.name}"
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(f"{name}/")
                else:
                    s = entry.stat(follow_symlinks=False)
                    found[name] = [s.st_size, s.st_mode, s.st_mtime_ns, s.st_ctime_ns, s.st_ino]
    return found


def _check(path: Path) -> int:
    """Return the CRC-32 of a plain file."""
    require_regular_file(path)
    check = 0
    with path.open("rb") as file:
        while part := file.read(2**20):
            check = zlib.crc32(part, check)
    return check


def _unpack_new(file: IO[bytes], folder: Path) -> None:
    temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=_PARTIAL))
    try:
        checks = extract(file, temporary / "new")
        files = _files(temporary / "new")
        unpacked = {name: [*found, checks[name]] for name, found in files.items()}
        listed = atomic_write(temporary / "list", json.dumps(unpacked))  # there may be thousands
        listed.replace(folder.with_suffix(".json"))  # of names beside the folder, which it sweeps
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


@cache  # once in a process: looking through a cache takes longer than unpacking into it
def _tidy(room: Path) -> None:
    """Remove what killed processes left, and what has not been used for months."""
    now = time.time()
    with os.scandir(room) as entries:  # there may be thousands
        for entry in entries:
            if entry.name.startswith(_PARTIAL) and _age(entry, now) > _STALE:
                shutil.rmtree(entry, ignore_errors=True)
            elif entry.name.endswith(".json") and _age(entry, now) > _UNUSED:
                shutil.rmtree(Path(entry).with_suffix(""), ignore_errors=True)
                Path(entry).unlink(missing_ok=True)


def _age(entry: os.DirEntry[str], now: float) -> float:
    try:
        return now - entry.stat().st_mtime
    except OSError:  # another process was faster
        return 0.0
