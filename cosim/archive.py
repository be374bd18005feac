"""Zip archives from strangers, unpacked once into the cache."""

from __future__ import annotations

import hashlib
import re
import shutil
import stat
import tempfile
import zipfile
import zlib
from pathlib import Path

import toolchain
from cosim.errors import CosimError

MAX_MEMBERS = 20_000
MAX_BYTES = 2 * 1024**3  # unpacked

_SUPPORTED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_UNSAFE = re.compile(r"^/|^[A-Za-z]:|(^|/)\.\.(/|$)|[\x00-\x1f]")


def unpack(path: Path, room: str, error: type[CosimError]) -> Path:
    """Unpack an archive to ``<cache>/<room>/<sha256 of the file>`` and return that folder.

    The folder appears whole or not at all; when it exists the archive is not opened again.

    Raises
    ------
    error
        When the file cannot be read, is no zip archive, or holds members that are not safe.
    """
    try:
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as fault:
        raise error(f"{path}: cannot be read: {fault.strerror}") from fault
    folder = toolchain.cache_directory() / room / digest
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        _unpack_new(path, folder, error)
    return folder


def _unpack_new(path: Path, folder: Path, error: type[CosimError]) -> None:
    temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=".unpack-"))
    try:
        with zipfile.ZipFile(path) as archive:
            if fault := _fault(archive):
                raise error(f"{path}: {fault}")
            archive.extractall(temporary)
        try:
            temporary.replace(folder)
        except OSError:
            if not folder.is_dir():  # else another process was faster
                raise
    except zipfile.BadZipFile as fault:
        raise error(f"{path}: not a zip archive, or a damaged one: {fault}") from fault
    except (zlib.error, EOFError) as fault:
        raise error(f"{path}: damaged zip archive: {fault}") from fault
    except OSError as fault:
        raise error(f"{path}: cannot be unpacked to {folder.parent}: {fault}") from fault
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _fault(archive: zipfile.ZipFile) -> str | None:
    members = archive.infolist()
    if len(members) > MAX_MEMBERS:
        return f"{len(members)} members; at most {MAX_MEMBERS} are unpacked"
    size = sum(member.file_size for member in members)
    if size > MAX_BYTES:
        return f"{size} bytes when unpacked; at most {MAX_BYTES} are"
    seen: set[str] = set()
    for member in members:
        name = member.orig_filename
        if "\\" in name:
            return f"member {name!r} has a backslash in its name, where the standard wants '/'"
        if _UNSAFE.search(name):
            return f"member {name!r} would leave the folder it is unpacked to"
        if stat.S_ISLNK(member.external_attr >> 16):
            return f"member {name!r} is a symbolic link; only files are unpacked"
        if member.flag_bits & 1:
            return f"member {name!r} is encrypted; pack it without a password"
        if member.compress_type not in _SUPPORTED:
            return f"member {name!r} is compressed by a method other than deflate; pack it again"
        if name.casefold() in seen:
            return f"member {name!r} occurs twice (upper and lower case count as the same)"
        seen.add(name.casefold())
    return None
