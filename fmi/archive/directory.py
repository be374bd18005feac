"""The directory of an archive, checked before anything is unpacked."""

from __future__ import annotations

import stat
import zipfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import PurePosixPath

from stickslip.fmi.archive.names import Refused, check_distinct, place
from stickslip.fmi.messages import shown

MAX_BYTES = 2 * 1024**3  # unpacked
MAX_RATIO = 500  # of what is large when unpacked; deflate itself ends at 1032
LARGE = 64 * 1024**2
_LOCAL = 30  # bytes of a member's own header, without its name
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_REGULAR = (0, stat.S_IFREG, stat.S_IFDIR)


def check_members(
    members: Sequence[zipfile.ZipInfo], stated: int
) -> list[tuple[PurePosixPath, zipfile.ZipInfo]]:
    """Check what the archive's directory says; return where each member goes.

    A file that occurs again with the same size and CRC-32 is left out.

    Parameters
    ----------
    stated : how many members there are, by the end of the archive
    """
    if len(members) != stated:
        raise Refused(
            f"damaged zip archive: {len(members)} members listed, {stated} stated at its end; copy"
            " or export it again"
        )
    for member in members:
        place(member.orig_filename)
        if fault := _fault(member):
            raise Refused(f"member {shown(member.orig_filename)} {fault}")
    _check_size("the archive", sum(m.file_size for m in members), _packed(members))
    _check_apart(members)
    different = {(m.orig_filename, m.file_size, m.CRC): m for m in reversed(members)}
    placed = [(place(m.orig_filename), m) for m in reversed(different.values())]
    check_distinct((path, is_folder(member)) for path, member in placed)
    return placed


def is_folder(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is a folder."""
    return member.orig_filename.endswith("/")


def is_link(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is a symbolic link."""
    return stat.S_ISLNK(member.external_attr >> 16)


def is_special(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is a pipe, a device or another file without content."""
    kind = stat.S_IFMT(member.external_attr >> 16)
    return member.create_system == 3 and kind not in (*_REGULAR, stat.S_IFLNK)


def is_encrypted(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is read with a password only."""
    return bool(member.flag_bits & 0x41)


def is_inflated(size: int, packed: int) -> bool:
    """Tell whether bytes are many and packed far tighter than data ever is."""
    return size > max(LARGE, MAX_RATIO * packed)


def _packed(members: Sequence[zipfile.ZipInfo]) -> int:
    return sum(member.compress_size for member in members)


def _fault(member: zipfile.ZipInfo) -> str | None:
    if is_link(member):
        return "is a symbolic link; only files are unpacked: pack the file itself"
    if is_special(member):
        mode = member.external_attr >> 16
        return f"is a special file (mode {mode:o}); only files and folders are unpacked"
    if is_encrypted(member):
        return "is encrypted; pack it without a password"
    if member.compress_type not in METHODS:
        return (
            f"is compressed by method {member.compress_type}, expected deflate or stored;"
            " pack the archive again"
        )
    if is_folder(member) and member.file_size:
        return f"is a folder with {member.file_size} bytes of content; pack the archive again"
    _check_size(f"member {shown(member.orig_filename)}", member.file_size, member.compress_size)
    return None


def _check_size(what: str, size: int, packed: int) -> None:
    if size > MAX_BYTES:
        raise Refused(f"{what} has {size} bytes when unpacked; at most {MAX_BYTES} are")
    if is_inflated(size, packed):
        raise Refused(
            f"{what} grows from {packed} to {size} bytes when unpacked, expected at most"
            f" {MAX_RATIO} times as much: a zip bomb; ask where it came from"
        )


def _check_apart(members: Sequence[zipfile.ZipInfo]) -> None:
    spans = sorted((m.header_offset, m.compress_size, m.orig_filename) for m in members)
    for (begin, size, name), (following, _, other) in pairwise(spans):
        if begin + _LOCAL + len(name) + size > following:
            raise Refused(
                f"members {shown(name)} and {shown(other)} overlap in the archive; export it again"
            )
