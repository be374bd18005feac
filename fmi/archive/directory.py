"""What an archive says of itself, checked before anything is unpacked: ends, names, sizes."""

import os
import re
import stat
import struct
import sys
import unicodedata
import zipfile
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import PurePosixPath
from typing import IO

from stickslip.fmi.messages import shown

_MAX_DEPTH = 64
_MAX_LENGTH = 1000  # bytes of a path
_MAX_PART = 255  # bytes, of every usual file system
_FOLDS = sys.platform in ("win32", "darwin")
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
_LEAVES = re.compile(r"^/|^[A-Za-z]:|(^|/)\.\.(/|$)")
# Device names of Windows, which they are with any extension, too.
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9\u00b9\u00b2\u00b3])", re.I)


class Refused(Exception):
    """An archive that is not unpacked; the message lacks its path, which the caller knows."""


def is_device(name: str) -> bool:
    """Tell whether Windows takes a file of this name for a device."""
    return _DEVICE.fullmatch(name.partition(".")[0].rstrip(" ")) is not None


def place(name: str) -> PurePosixPath:
    """Return where a member goes, relative to the folder it is unpacked to."""
    if fault := _name_fault(name):
        raise Refused(f"member {shown(name)} {fault}")
    return PurePosixPath(name)


def _name_fault(name: str) -> str | None:
    if _CONTROL.search(name):
        return "has control characters in its name; pack the archive again without them"
    if "\\" in name:
        return "has a backslash in its name, where the standard wants '/'; pack the archive again"
    if _LEAVES.search(name):
        return "would leave the folder it is unpacked to; only relative paths are unpacked"
    parts = name.removesuffix("/").split("/")
    if not all(parts):
        return "has an empty part in its path; pack the archive again"
    if parts[-1] == "." and not name.endswith("/"):
        return "names a folder, and is a file; pack the archive again"
    if len(parts) > _MAX_DEPTH:
        return f"lies {len(parts)} folders deep, expected at most {_MAX_DEPTH}"
    length = len(name.encode())
    if length > _MAX_LENGTH or any(len(part.encode()) > _MAX_PART for part in parts):
        most = f"at most {_MAX_LENGTH}, {_MAX_PART} in a part"
        return f"has a path of {length} bytes, expected {most}"
    if os.name == "nt":
        if ":" in name:
            return "has a colon in its name, which names a drive or a stream on Windows; rename it"
        if any(p.endswith((".", " ")) and p != "." for p in parts):
            return "has a name with a dot or blank at its end, which Windows drops; rename it"
        if any(map(is_device, parts)):
            return "has the name of a device of Windows; rename it"
    return None


def check_distinct(places: Iterable[tuple[PurePosixPath, bool]]) -> None:
    """Check that no two members (path, is it a folder) have the same place in this file system."""
    files: dict[str, PurePosixPath] = {}
    folders: dict[str, PurePosixPath] = {}
    for path, is_folder in places:
        key = _key(path)
        if not is_folder:
            if key in files:
                raise Refused(f"member {shown(str(path))} occurs twice; keep one")
            files[key] = path
        for folder in (path, *path.parents) if is_folder else path.parents:
            folders.setdefault(_key(folder), folder)
    if both := files.keys() & folders.keys():
        name = shown(str(files[min(both)]))
        raise Refused(f"member {name} is a file, and a folder of other members; rename one")


def _key(path: PurePosixPath) -> str:
    name = str(path)
    return unicodedata.normalize("NFC", name).casefold() if _FOLDS else name


MAX_MEMBERS = 20_000
_MAX_DIRECTORY = 32 * 1024**2  # bytes that list the members
_END = struct.Struct("<4s4H2LH")
_END_MARK = b"PK\x05\x06"
_END64 = struct.Struct("<4sQ2H2L4Q")
_END64_MARK = b"PK\x06\x06"
_POINTER = struct.Struct("<4sLQL")  # to _END64


def check_frame(file: IO[bytes]) -> int:
    """Return the number of members of one zip archive from first byte to last, else ValueError."""
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
        side = "behind" if behind > 0 else "missing at"
        what = f"{abs(behind)} bytes {side} the end of the zip archive"
        raise ValueError(f"{what}; copy or export it again")
    end = begin + found
    if members == 0xFFFF or 0xFFFFFFFF in (length, offset):
        members, length, offset, end = _end64(file, end, (members, length, offset, end))
    if members > MAX_MEMBERS or length > _MAX_DIRECTORY:
        what = f"{members} members, listed in {length} bytes"
        raise ValueError(f"{what}; at most {MAX_MEMBERS} are unpacked")
    if (before := end - length - offset) or (members and head != b"PK\x03\x04"):
        what = f"{abs(before)} bytes {'before' if before >= 0 else 'missing from'} the zip archive"
        why = "it does not begin with its first member; copy or export it again"
        raise ValueError(f"{what}: {why}")
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
        what = "damaged zip archive: its end points behind itself"
        raise ValueError(f"{what}; copy or export it again")
    file.seek(at)
    mark, *_, members, length, offset = _END64.unpack(file.read(_END64.size))
    if mark != _END64_MARK:
        raise ValueError("damaged zip archive: its zip64 end is missing; copy or export it again")
    return members, length, offset, at


MAX_BYTES = 2 * 1024**3  # unpacked
MAX_RATIO = 500  # of what is large when unpacked; deflate itself ends at 1032
LARGE = 64 * 1024**2
_LOCAL = 30  # bytes of a member's own header, without its name
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_REGULAR = (0, stat.S_IFREG, stat.S_IFDIR)


def check_members(
    members: Sequence[zipfile.ZipInfo], stated: int
) -> list[tuple[PurePosixPath, zipfile.ZipInfo]]:
    """Check the directory against the number of members stated; return where each goes, once."""
    if len(members) != stated:
        what = f"{len(members)} members listed, {stated} stated at its end"
        raise Refused(f"damaged zip archive: {what}; copy or export it again")
    for member in members:
        place(member.orig_filename)
        if fault := _fault(member):
            raise Refused(f"member {shown(member.orig_filename)} {fault}")
    packed = sum(m.compress_size for m in members)
    _check_size("the archive", sum(m.file_size for m in members), packed)
    spans = sorted((m.header_offset, m.compress_size, m.orig_filename) for m in members)
    for (begin, size, name), (following, _, other) in pairwise(spans):
        if begin + _LOCAL + len(name) + size > following:
            what = f"members {shown(name)} and {shown(other)} overlap in the archive"
            raise Refused(f"{what}; export it again")
    # A file that occurs again with the same size and CRC-32 is left out.
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


def _fault(member: zipfile.ZipInfo) -> str | None:
    if is_link(member):
        return "is a symbolic link; only files are unpacked: pack the file itself"
    if is_special(member):
        mode = member.external_attr >> 16
        return f"is a special file (mode {mode:o}); only files and folders are unpacked"
    if is_encrypted(member):
        return "is encrypted; pack it without a password"
    if member.compress_type not in METHODS:
        method = f"is compressed by method {member.compress_type}, expected deflate or stored"
        return f"{method}; pack the archive again"
    if is_folder(member) and member.file_size:
        return f"is a folder with {member.file_size} bytes of content; pack the archive again"
    _check_size(f"member {shown(member.orig_filename)}", member.file_size, member.compress_size)
    return None


def _check_size(what: str, size: int, packed: int) -> None:
    if size > MAX_BYTES:
        raise Refused(f"{what} has {size} bytes when unpacked; at most {MAX_BYTES} are")
    if is_inflated(size, packed):
        grown = f"grows from {packed} to {size} bytes when unpacked"
        most = f"expected at most {MAX_RATIO} times as much: a zip bomb; ask where it came from"
        raise Refused(f"{what} {grown}, {most}")
