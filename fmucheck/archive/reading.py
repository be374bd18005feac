"""A zip archive as it is, before anything is unpacked."""

from __future__ import annotations

import re
import shutil
import stat
import zipfile
import zlib
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

MAX_MEMBERS = 20_000
MAX_BYTES = 2 * 1024**3  # unpacked
MAX_RATIO = 500  # of a member that is large when unpacked
LARGE = 64 * 1024**2

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_UNSAFE = re.compile(r"^$|^/|\\|^[A-Za-z]:|(^|/)\.\.(/|$)|[\x00-\x1f]")


@dataclass
class Archive:
    """What the directory of a zip archive lists.

    Attributes
    ----------
    fault : why it cannot be read at all
    damaged : member name -> why its content cannot be read; filled by ``unpack``
    """

    path: Path
    fault: str | None = None
    members: list[zipfile.ZipInfo] = field(default_factory=list)
    damaged: dict[str, str] = field(default_factory=dict)

    @property
    def files(self) -> list[zipfile.ZipInfo]:
        """The members that are no folders."""
        return [m for m in self.members if not m.orig_filename.endswith("/")]

    @property
    def bytes(self) -> int:
        """Size when unpacked, as declared."""
        return sum(member.file_size for member in self.members)

    @property
    def is_bomb(self) -> bool:
        """Whether unpacking would take more than a real FMU ever does."""
        return (
            len(self.members) > MAX_MEMBERS
            or self.bytes > MAX_BYTES
            or any(is_inflated(m) for m in self.members)
        )


def is_inflated(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is large and packed far tighter than data ever is."""
    return member.file_size > max(LARGE, MAX_RATIO * member.compress_size)


def is_unsafe(name: str) -> bool:
    """Tell whether a member's name could leave the folder it is unpacked to."""
    return bool(_UNSAFE.search(name))


def is_link(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is a symbolic link."""
    return stat.S_ISLNK(member.external_attr >> 16)


def is_readable(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member's content can be read without a password or other methods."""
    return member.compress_type in _METHODS and not member.flag_bits & 1


def read_archive(path: Path) -> Archive:
    """Read the directory of an archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            return Archive(path, members=archive.infolist())
    except (zipfile.BadZipFile, OSError, EOFError, ValueError, NotImplementedError) as fault:
        return Archive(path, fault=getattr(fault, "strerror", None) or str(fault))


def unpack(archive: Archive, folder: Path) -> frozenset[str]:
    """Write every safe, readable member below ``folder`` and return their names.

    Links, members with unsafe names and further members of the same name are left out; damaged
    ones are noted.
    """
    seen: set[str] = set()
    with zipfile.ZipFile(archive.path) as file:
        for member in archive.files:
            name = member.orig_filename
            if is_unsafe(name) or is_link(member) or not is_readable(member) or name in seen:
                continue
            seen.add(name)
            try:
                target = folder / name
                target.parent.mkdir(parents=True, exist_ok=True)
                with file.open(member) as source, target.open("wb") as copy:
                    shutil.copyfileobj(source, copy)
            except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError) as fault:
                archive.damaged[name] = str(fault)
                with suppress(OSError):  # its name may be too long to be asked for
                    target.unlink()
    return frozenset(seen - archive.damaged.keys())
