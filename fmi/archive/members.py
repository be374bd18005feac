"""Extraction of members; the bytes that come out are counted, whatever the headers say."""

from __future__ import annotations

import errno
import shutil
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from stickslip.fmi.archive import directory
from stickslip.fmi.archive.frame import check_frame
from stickslip.fmi.archive.names import Refused
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
        _check_room(members, folder.parent)
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


def _check_room(members: Sequence[zipfile.ZipInfo], folder: Path) -> None:
    total = sum(member.file_size for member in members)
    free = shutil.disk_usage(folder).free
    if total > free:
        raise OSError(errno.ENOSPC, f"{total} bytes, but only {free} are free", str(folder))


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
        raise Refused(
            f"{what}: {size} bytes, expected {member.file_size} as its header says;"
            " copy or export the archive again"
        )


@contextmanager
def _blaming(what: str) -> Iterator[None]:
    try:
        yield
    except FAULTS as fault:
        raise Refused(f"{what}: {printable(str(fault))}; copy or export it again") from fault
