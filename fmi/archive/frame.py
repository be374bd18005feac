"""A file that is one zip archive, told before anything of it is read."""

from __future__ import annotations

import struct
from typing import IO

MAX_MEMBERS = 20_000
_MAX_DIRECTORY = 32 * 1024**2  # bytes that list the members

_END = struct.Struct("<4s4H2LH")
_END_MARK = b"PK\x05\x06"
_END64 = struct.Struct("<4sQ2H2L4Q")
_END64_MARK = b"PK\x06\x06"
_POINTER = struct.Struct("<4sLQL")  # to _END64


def check_frame(file: IO[bytes]) -> int:
    """Check that a file is one zip archive from first byte to last; return how many members.

    Anything before or after it would be read by some tools and not by others.

    Raises
    ------
    ValueError
        Also when the list of members is too long to be read at all.
    """
    size = file.seek(0, 2)
    if not size:
        raise ValueError("not a zip archive: the file is empty; copy it again")
    file.seek(0)
    head = file.read(4)
    begin = max(0, size - _END.size - 0xFFFF)
    file.seek(begin)
    tail = file.read()
    found = tail.rfind(_END_MARK)
    if found < 0 or len(tail) - found < _END.size:
        what = "a damaged one: its end is missing" if head[:2] == b"PK" else "its end is missing"
        raise ValueError(f"not a zip archive, or {what}; copy or export it again")
    fields: tuple[int, ...] = _END.unpack_from(tail, found)[4:]
    members, length, offset, comment = fields
    if behind := len(tail) - found - _END.size - comment:
        raise ValueError(
            f"{abs(behind)} bytes {'behind' if behind > 0 else 'missing at'} the end of the zip"
            " archive; copy or export it again"
        )
    end = begin + found
    if members == 0xFFFF or 0xFFFFFFFF in (length, offset):
        members, length, offset, end = _end64(file, end, (members, length, offset, end))
    if members > MAX_MEMBERS or length > _MAX_DIRECTORY:
        raise ValueError(
            f"{members} members, listed in {length} bytes; at most {MAX_MEMBERS} are unpacked"
        )
    if (before := end - length - offset) or (members and head != b"PK\x03\x04"):
        raise ValueError(
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
        raise ValueError(
            "damaged zip archive: its end points behind itself; copy or export it again"
        )
    file.seek(at)
    mark, *_, members, length, offset = _END64.unpack(file.read(_END64.size))
    if mark != _END64_MARK:
        raise ValueError("damaged zip archive: its zip64 end is missing; copy or export it again")
    return members, length, offset, at
