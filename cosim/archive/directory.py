"""What an archive says of itself, checked before anything is unpacked."""

from __future__ import annotations

import stat
import struct
import zipfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import PurePosixPath
from typing import IO

from cosim.archive.errors import Refused
from cosim.archive.names import check_distinct, place
from cosim.names import shown

MAX_MEMBERS = 20_000
MAX_BYTES = 2 * 1024**3  # unpacked
MAX_RATIO = 500  # of what is large when unpacked; deflate itself ends at 1032
LARGE = 64 * 1024**2
_MAX_DIRECTORY = 32 * 1024**2  # bytes that list the members

_END = struct.Struct("<4s4H2LH")
_END_MARK = b"PK\x05\x06"
_END64 = struct.Struct("<4sQ2H2L4Q")
_END64_MARK = b"PK\x06\x06"
_POINTER = struct.Struct("<4sLQL")  # to _END64
_LOCAL = 30  # bytes of a member's own header, without its name
_METHODS = {zipfile.ZIP_STORED: "stored", zipfile.ZIP_DEFLATED: "deflate"}
_REGULAR = (0, stat.S_IFREG, stat.S_IFDIR)


def check_frame(file: IO[bytes]) -> int:
    """Check that a file is one zip archive from first byte to last; return how many members.

    Anything before or after it would be read by some tools and not by others.

    Raises
    ------
    Refused
        Also when the list of members is too long to be read at all.
    """
    size = file.seek(0, 2)
    if not size:
        raise Refused("not a zip archive: the file is empty; copy it again")
    file.seek(0)
    head = file.read(4)
    begin = max(0, size - _END.size - 0xFFFF)
    file.seek(begin)
    tail = file.read()
    found = tail.rfind(_END_MARK)
    if found < 0 or len(tail) - found < _END.size:
        what = "a damaged one: its end is missing" if head[:2] == b"PK" else "its end is missing"
        raise Refused(f"not a zip archive, or {what}; copy or export it again")
    fields: tuple[int, ...] = _END.unpack_from(tail, found)[4:]
    members, length, offset, comment = fields
    if behind := len(tail) - found - _END.size - comment:
        raise Refused(
            f"{abs(behind)} bytes {'behind' if behind > 0 else 'missing at'} the end of the zip"
            " archive; copy or export it again"
        )
    end = begin + found
    if members == 0xFFFF or 0xFFFFFFFF in (length, offset):
        members, length, offset, end = _end64(file, end, (members, length, offset, end))
    if members > MAX_MEMBERS or length > _MAX_DIRECTORY:
        raise Refused(
            f"{members} members, listed in {length} bytes; at most {MAX_MEMBERS} are unpacked"
        )
    if (before := end - length - offset) or (members and head != b"PK\x03\x04"):
        raise Refused(
            f"{abs(before)} bytes {'before' if before >= 0 else 'missing from'} the zip archive:"
            " it does not begin with its first member; copy or export it again"
        )
    return members


def _end64(file: IO[bytes], end: int, plain: tuple[int, ...]) -> tuple[int, ...]:
    """Return number of members, length and place of their list, and its end, of a zip64."""
    if end < _POINTER.size + _END64.size:
        return plain
    file.seek(end - _POINTER.size)
    mark, _, at, _ = _POINTER.unpack(file.read(_POINTER.size))
    if mark != b"PK\x06\x07":
        return plain
    if at + _END64.size > end:
        raise Refused("damaged zip archive: its end points behind itself; copy or export it again")
    file.seek(at)
    mark, *_, members, length, offset = _END64.unpack(file.read(_END64.size))
    if mark != _END64_MARK:
        raise Refused("damaged zip archive: its zip64 end is missing; copy or export it again")
    return members, length, offset, at


def check_members(members: Sequence[zipfile.ZipInfo], stated: int) -> list[PurePosixPath]:
    """Check what the archive's directory says; return where each member goes.

    Parameters
    ----------
    stated : how many members there are, by the end of the archive

    Raises
    ------
    Refused
        When a member is no plain file or folder, cannot be read, lies where another one does, or
        all together are too many or too much.
    """
    if len(members) != stated:
        raise Refused(
            f"damaged zip archive: {len(members)} members listed, {stated} stated at its end; copy"
            " or export it again"
        )
    places = [place(member.orig_filename) for member in members]
    for member in members:
        if fault := _fault(member):
            raise Refused(f"member {shown(member.orig_filename)} {fault}")
    _check_size("the archive", sum(m.file_size for m in members), _packed(members))
    check_distinct((path, is_folder(member)) for path, member in zip(places, members, strict=True))
    _check_apart(members)
    return places


def is_folder(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is a folder."""
    return member.orig_filename.endswith("/")


def _packed(members: Sequence[zipfile.ZipInfo]) -> int:
    return sum(member.compress_size for member in members)


def _fault(member: zipfile.ZipInfo) -> str | None:
    mode = member.external_attr >> 16
    if stat.S_ISLNK(mode):
        return "is a symbolic link; only files are unpacked: pack the file itself"
    if member.create_system == 3 and stat.S_IFMT(mode) not in _REGULAR:
        return f"is a special file (mode {mode:o}); only files and folders are unpacked"
    if member.flag_bits & 0x41:
        return "is encrypted; pack it without a password"
    if member.compress_type not in _METHODS:
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
    if size > max(LARGE, MAX_RATIO * packed):
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
