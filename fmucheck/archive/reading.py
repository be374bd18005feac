"""A zip archive as it is, before anything is unpacked."""

from __future__ import annotations

import re
import zipfile
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from stickslip.fmi.archive.directory import (
    MAX_BYTES,
    METHODS,
    is_encrypted,
    is_inflated,
    is_link,
    is_special,
)
from stickslip.fmi.archive.errors import Refused
from stickslip.fmi.archive.frame import MAX_MEMBERS, check_frame
from stickslip.fmi.archive.members import FAULTS, extract_file
from stickslip.fmi.files import open_regular_file

_MAGIC = b"PK"
_UNSAFE = re.compile(r"^$|^/|\\|^[A-Za-z]:|(^|/)\.\.(/|$)|[\x00-\x1f]")


@dataclass
class Archive:
    """What the directory of a zip archive lists.

    Attributes
    ----------
    fault : why it cannot be read at all
    is_zip : it begins as one
    damaged : member name -> why its content cannot be read; filled by ``unpack``
    """

    path: Path
    fault: str | None = None
    is_zip: bool = False
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
    def packed(self) -> int:
        """Size of all members as they are."""
        return sum(member.compress_size for member in self.members)

    @property
    def is_bomb(self) -> bool:
        """Whether unpacking would take more than a real FMU ever does."""
        return (
            len(self.members) > MAX_MEMBERS
            or self.bytes > MAX_BYTES
            or is_inflated(self.bytes, self.packed)
            or any(is_inflated(m.file_size, m.compress_size) for m in self.members)
        )


def is_unsafe(name: str) -> bool:
    """Tell whether a member's name could leave the folder it is unpacked to."""
    return bool(_UNSAFE.search(name))


def is_readable(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member's content can be read without a password or other methods."""
    return member.compress_type in METHODS and not is_encrypted(member)


def read_archive(path: Path) -> Archive:
    """Read the directory of an archive."""
    archive = Archive(path)
    try:
        with open_regular_file(path) as file:
            archive.is_zip = file.read(2) == _MAGIC
            stated = check_frame(file)
            with zipfile.ZipFile(file) as content:
                archive.members = content.infolist()
            if len(archive.members) != stated:
                archive.fault = f"{len(archive.members)} members listed, {stated} stated at its end"
    except (*FAULTS, OSError) as fault:
        said = getattr(fault, "strerror", None) or str(fault)
        archive.fault = said.partition(";")[0]  # the advice of a rule follows
    return archive


def unpack(archive: Archive, folder: Path) -> frozenset[str]:
    """Write every safe, readable member below ``folder`` and return their names.

    Links, members with unsafe names and further members of the same name are left out; damaged
    ones are noted.
    """
    seen: set[str] = set()
    for member in archive.members:
        if member.orig_filename.endswith("/") and member.file_size:
            archive.damaged[member.orig_filename] = f"a folder with {member.file_size} bytes"
    with zipfile.ZipFile(archive.path) as file:
        for member in archive.files:
            name = member.orig_filename
            odd = is_unsafe(name) or is_link(member) or is_special(member)
            if odd or not is_readable(member) or name in seen:
                continue
            seen.add(name)
            try:
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                extract_file(file, member, folder / name)
            except (Refused, OSError, ValueError) as fault:
                archive.damaged[name] = str(fault)
                with suppress(OSError):  # its name may be too long to be asked for
                    (folder / name).unlink()
    return frozenset(seen - archive.damaged.keys())
