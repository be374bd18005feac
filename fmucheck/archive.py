"""Rules about the zip archive and the names in it; reading and unpacking without trusting it."""

import re
import unicodedata
import zipfile
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from stickslip.fmi.archive import directory
from stickslip.fmi.archive.unpacked import FAULTS, extract_file
from stickslip.fmi.files import open_regular_file
from stickslip.fmucheck.rules import Claims, error, note, warning

_MAGIC = b"PK"
_UNSAFE = re.compile(r"^$|^/|\\|^[A-Za-z]:|(^|/)\.\.(/|$)|[\x00-\x1f]")


@dataclass
class Archive:
    """What the directory of a zip archive lists."""

    path: Path
    fault: str | None = None  # why it cannot be read at all
    is_zip: bool = False  # it begins as one
    members: list[zipfile.ZipInfo] = field(default_factory=list)
    damaged: dict[str, str] = field(default_factory=dict)  # member -> why, filled by ``unpack``

    @property
    def files(self) -> list[zipfile.ZipInfo]:
        """The members that are files."""
        return [m for m in self.members if not m.orig_filename.endswith("/")]


def is_unsafe(name: str) -> bool:
    """Tell whether a member's name could leave the folder it is unpacked to."""
    return bool(_UNSAFE.search(name))


def read_archive(path: Path) -> Archive:
    """Read the directory of an archive."""
    archive = Archive(path)
    try:
        with open_regular_file(path) as file:
            archive.is_zip = file.read(2) == _MAGIC
            stated = directory.check_frame(file)
            with zipfile.ZipFile(file) as content:
                archive.members = content.infolist()
            if len(archive.members) != stated:
                archive.fault = f"{len(archive.members)} members listed, {stated} stated at its end"
    except (*FAULTS, OSError) as fault:
        message = getattr(fault, "strerror", None) or str(fault)
        archive.fault = message.partition(";")[0]  # the advice of a rule follows
    return archive


def unpack(archive: Archive, folder: Path) -> frozenset[str]:
    """Write the safe, readable members below ``folder``; note damaged ones, return the others."""
    seen: set[str] = set()
    for member in archive.members:
        if member.orig_filename.endswith("/") and member.file_size:
            archive.damaged[member.orig_filename] = f"a folder with {member.file_size} bytes"
    with zipfile.ZipFile(archive.path) as file:
        for member in archive.files:
            name = member.orig_filename
            odd = is_unsafe(name) or directory.is_link(member) or directory.is_special(member)
            odd = odd or member.compress_type not in directory.METHODS
            if odd or directory.is_encrypted(member) or name in seen:
                continue
            seen.add(name)
            try:
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                extract_file(file, member, folder / name)
            except (directory.Refused, OSError, ValueError) as fault:
                archive.damaged[name] = str(fault)
                with suppress(OSError):  # its name may be too long to be asked for
                    (folder / name).unlink()
    return frozenset(seen - archive.damaged.keys())


_METHODS = {0: "stored", 8: "deflate", 12: "bzip2", 14: "lzma", 93: "zstandard"}
_DESCRIPTION = "modelDescription.xml"
_LONGEST = 200  # characters of a path


@error("2.3", "2.5", "export the FMU again; it must be a zip archive")
def not_a_zip(archive: Archive) -> Claims:
    """The file is not a zip archive, or cannot be read."""
    if archive.fault and not archive.is_zip:
        yield str(archive.path), archive.fault


@error("2.3", "2.5", "copy or export the FMU again")
def damaged_archive(archive: Archive) -> Claims:
    """The archive is truncated or its directory is damaged."""
    if archive.fault and archive.is_zip:
        yield str(archive.path), f"begins as a zip archive, but: {archive.fault}"


@error("2.3", "2.5", "do not unpack it; ask where it came from")
def zip_bomb(archive: Archive) -> Claims:
    """Unpacking would fill the disk: too many members, too many bytes, or packed too tightly."""
    if len(archive.members) > directory.MAX_MEMBERS:
        count = len(archive.members)
        yield str(archive.path), f"{count} members; at most {directory.MAX_MEMBERS} are unpacked"
    each = [(m.orig_filename, m.compress_size, m.file_size) for m in archive.members]
    total = sum(m.file_size for m in archive.members)
    if total > directory.MAX_BYTES:
        what = f"{total} bytes when unpacked; at most {directory.MAX_BYTES} are"
        yield str(archive.path), what
    everything = (str(archive.path), sum(m.compress_size for m in archive.members), total)
    for name, packed, size in [everything, *each]:
        if directory.is_inflated(size, packed):
            yield name, f"{packed} bytes become {size}; it is not unpacked"


@error("2.3", "2.5", "give members relative paths inside the FMU")
def unsafe_path(archive: Archive) -> Claims:
    """A member's path is absolute, names a drive, goes up, or holds a backslash."""
    for member in archive.members:
        if is_unsafe(member.orig_filename):
            name = member.orig_filename
            why = "has a backslash" if "\\" in name else "could leave the folder of the FMU"
            yield repr(name), f"this path {why}"


@error("2.3", "2.5", "keep one of them")
def duplicate_member(archive: Archive) -> Claims:
    """Two members have the same path, so that readers see different files."""
    for name, count in Counter(m.orig_filename for m in archive.files).items():
        if count > 1:
            yield name, f"is in the archive {count} times"


@warning("2.3", "2.5", "rename one of them")
def colliding_members(archive: Archive) -> Claims:
    """Two paths differ in case or accents only, or one is a folder: some take them for one."""
    first: dict[str, str] = {}
    for name in {m.orig_filename: None for m in archive.members}:
        key = unicodedata.normalize("NFC", name.removesuffix("/")).casefold()
        other = first.setdefault(key, name)
        if other.strip("/") == name.strip("/") and other != name:
            yield name, "is a file and a folder"
        elif other != name:
            yield name, f"differs from {other} in case or accents only"


@warning("2.3", "2.5", "rename it")
def unportable_path(archive: Archive) -> Claims:
    """A path that not every system has: of a device, with a colon, ending in a dot, too long..."""
    for name in (m.orig_filename for m in archive.members if not is_unsafe(m.orig_filename)):
        parts = name.removesuffix("/").split("/")
        if ":" in name:
            yield name, "has a colon, which names a drive or a stream on Windows"
        if not all(parts):
            yield name, "has an empty part"
        if any(part.endswith((".", " ")) and part != "." for part in parts):
            yield name, "has a dot or blank at the end of a part, which Windows drops"
        if any(map(directory.is_device, parts)):
            yield name, "has the name of a device of Windows"
        if len(name) > _LONGEST:
            yield name, f"has {len(name)} characters; with its folder, Windows takes 260"


@error("2.3", "2.5", "pack the file itself", "members")
def link_in_archive(member: zipfile.ZipInfo) -> Iterator[str]:
    """A member is a symbolic link, a pipe or a device."""
    if directory.is_link(member):
        yield "is a symbolic link; it is not unpacked"
    elif directory.is_special(member):
        yield "is a pipe or a device; it is not unpacked"


@error("2.3", "2.5", "pack without a password", "members")
def encrypted_member(member: zipfile.ZipInfo) -> Iterator[str]:
    """A member is encrypted."""
    if directory.is_encrypted(member):
        yield "is encrypted"


@error("2.3", "2.5", "pack with deflate, or without compression", "members")
def compression_method(member: zipfile.ZipInfo) -> Iterator[str]:
    """A member is packed with something other than deflate."""
    if member.compress_type not in directory.METHODS:
        method = _METHODS.get(member.compress_type, f"method {member.compress_type}")
        yield f"is packed with {method}; expected deflate or stored"


@error(None, "2.5", "pack without zip64 and other new features", "members")
def zip_version(member: zipfile.ZipInfo) -> Iterator[str]:
    """A member needs a newer zip than version 2.0 to unpack."""
    if member.extract_version > 20 and member.compress_type in directory.METHODS:
        version = f"{member.extract_version / 10:.1f}"
        yield f"needs version {version} to extract; at most 2.0 is allowed"


@error(None, "2.5", "write sizes into the local header", "files")
def stored_with_data_descriptor(member: zipfile.ZipInfo) -> Iterator[str]:
    """A stored member has its size behind its data (general purpose bit 3)."""
    if member.compress_type == 0 and member.flag_bits & 8:
        yield "is stored, and has general purpose bit 3 set"


@error("2.3", "2.5", "export or copy the FMU again")
def damaged_member(archive: Archive) -> Claims:
    """A member's content does not match its checksum, or cannot be unpacked."""
    yield from archive.damaged.items()


@error("2.3", "2.5", "put modelDescription.xml at the root")
def no_model_description(archive: Archive) -> Claims:
    """modelDescription.xml is not at the root of the archive, spelled like this."""
    names = [member.orig_filename for member in archive.files]
    if archive.fault or _DESCRIPTION in names:
        return
    near = [n for n in names if n.replace("\\", "/").casefold().endswith(_DESCRIPTION.casefold())]
    hint = f"; there is {near[0]}" if near else ""
    yield str(archive.path), f"no {_DESCRIPTION} at the root{hint}"


@warning("2.3", "2.5", "name it .fmu")
def not_named_fmu(archive: Archive) -> Claims:
    """The file's name does not end with .fmu."""
    if archive.path.suffix != ".fmu":
        yield str(archive.path), f"ends with '{archive.path.suffix}'; importers look for .fmu"


@note("2.3", "2.5", "use ASCII names", "members")
def foreign_letters(member: zipfile.ZipInfo) -> Iterator[str]:
    """A path has letters outside ASCII, which some systems unpack under another name."""
    if not member.orig_filename.isascii():
        yield "has letters outside ASCII"
