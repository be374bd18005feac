"""Shared libraries as files, read without loading them: ELF, PE and Mach-O."""

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from operator import itemgetter

from stickslip.fmi.errors import Fault

MOST_SYMBOLS = 500_000
"""In a table; the largest libraries have a tenth of them."""
MOST_COMMANDS = 10_000
"""In the dynamic segment of ELF, and of Mach-O: some dozens are usual."""
MOST_SECTIONS = 96
"""Of PE: Windows loads no more."""
MOST_NAMES = 65_536
"""Of functions in PE, which have ordinals of 16 bits."""
_LONGEST = 4096  # bytes of a name
_MOST_TEXT = 2**25  # bytes of all names


class NotALibrary(Fault, ValueError):
    """The bytes are not a shared library that can be read."""


@dataclass(frozen=True)
class Library:
    """One shared library; a universal file of macOS has several ``targets``."""

    targets: frozenset[str]  # platforms it runs on, such as ``x86_64-linux``
    exports: frozenset[str]  # names of the functions that can be loaded from it
    needs: tuple[str, ...]  # file names of the libraries it loads itself
    unsigned: bool = False  # a part for arm64 macOS lacks the signature that it is loaded with


class Names:
    """The strings of a library, which end with a zero byte."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._left = _MOST_TEXT

    def at(self, place: int) -> str:
        """Return the name that begins at a byte; ValueError where names are too long."""
        end = self._data.find(b"\0", place, place + _LONGEST)
        if end < 0:
            raise ValueError(f"a name at byte {place:#x} that does not end within {_LONGEST} bytes")
        self._left -= end - place
        if self._left < 0:
            raise ValueError(f"names of more than {_MOST_TEXT} bytes")
        return self._data[place:end].decode("latin-1")


def _checked(count: int, what: str, most: int = MOST_SYMBOLS) -> int:
    """Return a number that a header states; ValueError where no library has so many."""
    if count > most:
        raise ValueError(f"{count} {what}; at most {most} are read")
    return count


_ELF = b"\x7fELF"
_ELF_MACHINES = {0x03: "x86", 0x3E: "x86_64", 0x28: "aarch32", 0xB7: "aarch64", 0xF3: "riscv"}
_LOAD, _DYNAMIC, _SHARED = 1, 2, 3
_NEEDED, _HASH, _STRINGS, _SYMBOL_TABLE, _GNU_HASH = 1, 4, 5, 6, 0x6FFFFEF5


def _read_elf(data: bytes) -> Library:
    wide, order = data[4] == 2, "<" if data[5] == 1 else ">"
    header = struct.unpack_from(order + ("HHIQQQIHHH" if wide else "HHIIIIIHHH"), data, 16)
    kind, number, _, _, table, _, _, _, size, count = header
    if kind != _SHARED:
        raise ValueError(f"ELF of type {kind} is no shared library")
    segment = struct.Struct(order + ("I4xQQ8xQ" if wide else "III4xI"))
    segments = [segment.unpack_from(data, table + k * size) for k in range(count)]
    loads = [(address, offset, size) for what, offset, address, size in segments if what == _LOAD]
    dynamic = next(((offset, size) for what, offset, _, size in segments if what == _DYNAMIC), None)
    if dynamic is None:
        raise ValueError("it has no dynamic segment")
    entry = struct.Struct(order + ("qQ" if wide else "iI"))
    length = _checked(dynamic[1] // entry.size, "entries in the dynamic segment", MOST_COMMANDS)
    entries = [entry.unpack_from(data, dynamic[0] + k * entry.size) for k in range(length)]
    tags = dict(reversed(entries))

    def offset(address: int) -> int:
        for start, place, size in loads:
            if start <= address < start + size:
                return int(place + address - start)
        raise ValueError(f"address {address:#x} lies in no segment")

    strings, names = offset(tags[_STRINGS]), Names(data)
    needs = [names.at(strings + value) for tag, value in entries if tag == _NEEDED]
    count = _checked(_symbol_count(data, tags, offset, order, wide), "symbols")
    exports = _elf_exports(data, offset(tags[_SYMBOL_TABLE]), count, order, wide)
    machine = _ELF_MACHINES.get(number, f"machine {number}")
    exported = frozenset(names.at(strings + name) for name in exports)
    return Library(frozenset({f"{machine}-linux"}), exported, tuple(needs))


def _symbol_count(
    data: bytes, tags: dict[int, int], offset: Callable[[int], int], order: str, wide: bool
) -> int:
    if _HASH in tags:
        return int(struct.unpack_from(order + "I", data, offset(tags[_HASH]) + 4)[0])
    table = offset(tags[_GNU_HASH])
    buckets, first, bloom, _ = struct.unpack_from(order + "IIII", data, table)
    place = table + 16 + bloom * (8 if wide else 4)
    _checked(buckets, "buckets of symbols")
    last = max(struct.unpack_from(f"{order}{buckets}I", data, place), default=0)
    if last < first:
        return int(first)
    chain = place + 4 * buckets + 4 * (last - first)
    while not struct.unpack_from(order + "I", data, chain)[0] & 1:
        chain, last = chain + 4, _checked(last + 1, "symbols")
    return int(last) + 1


def _elf_exports(data: bytes, table: int, count: int, order: str, wide: bool) -> list[int]:
    """Return places in the string table of the symbols that are defined and visible."""
    symbol = struct.Struct(order + ("IBBHQQ" if wide else "IIIBBH"))
    picked = itemgetter(*((0, 1, 3) if wide else (0, 3, 5)))
    found = []
    for k in range(count):
        name, info, section = picked(symbol.unpack_from(data, table + k * symbol.size))
        if section and info >> 4 in (1, 2):  # global or weak
            found.append(name)
    return found


_PE = b"MZ"
_PE_MACHINES = {0x14C: "x86", 0x8664: "x86_64", 0xAA64: "aarch64", 0x1C4: "aarch32"}
_IS_DLL = 0x2000


def _read_pe(data: bytes) -> Library:
    (header,) = struct.unpack_from("<I", data, 0x3C)
    if data[header : header + 4] != b"PE\0\0":
        raise ValueError("it has no PE header")
    number, sections, _, _, _, optional, flags = struct.unpack_from("<HHIIIHH", data, header + 4)
    if not flags & _IS_DLL:
        raise ValueError("it is a program, not a library")
    _checked(sections, "sections", MOST_SECTIONS)
    start = header + 24
    (magic,) = struct.unpack_from("<H", data, start)
    directories = start + (112 if magic == 0x20B else 96)
    table = start + optional
    parts = [struct.unpack_from("<8sIIII", data, table + 40 * k) for k in range(sections)]

    def offset(address: int) -> int:
        for _, size, first, stored, place in parts:
            if first <= address < first + max(size, stored):
                return int(place + address - first)
        raise ValueError(f"address {address:#x} lies in no section")

    names = Names(data)
    exports, needs = [], []
    (exported,) = struct.unpack_from("<I", data, directories)
    if exported:
        count, _, table = struct.unpack_from("<III", data, offset(exported) + 24)
        _checked(count, "exported names", MOST_NAMES)
        addresses = struct.unpack_from(f"<{count}I", data, offset(table)) if count else ()
        exports = [names.at(offset(address)) for address in addresses]
    (imported,) = struct.unpack_from("<I", data, directories + 8)
    if imported:
        place = offset(imported)
        while name := struct.unpack_from("<I", data, place + 12)[0]:
            needs.append(names.at(offset(name)))
            _checked(len(needs), "libraries that it needs", MOST_NAMES)
            place += 20
    machine = _PE_MACHINES.get(number, f"machine {number:#x}")
    return Library(frozenset({f"{machine}-windows"}), frozenset(exports), tuple(needs))


_THIN = {b"\xcf\xfa\xed\xfe": True, b"\xce\xfa\xed\xfe": False}
_FAT = b"\xca\xfe\xba\xbe"
_MACH_O_MACHINES = {7: "x86", 0x01000007: "x86_64", 12: "aarch32", 0x0100000C: "aarch64"}
_LIBRARIES = (6, 8)  # dylib and bundle
_SYMBOL_COMMAND, _SIGNATURE = 0x2, 0x1D
_LOADS = (0xC, 0x80000018, 0x8000001F, 0x23 | 0x80000000)  # plain, weak, re-exported, upward
_OUTSIDE, _HIDDEN, _KIND, _DEFINED, _DEBUG = 0x01, 0x10, 0x0E, 0x0E, 0xE0


def _read_macho(data: bytes) -> Library:
    if data[:4] != _FAT:
        return _part(data)
    (count,) = struct.unpack_from(">I", data, 4)
    if not 0 < count < 20:  # a Java class begins with the same four bytes
        raise ValueError(f"a universal file with {count} parts")
    places = [struct.unpack_from(">IIIII", data, 8 + 20 * k) for k in range(count)]
    parts = [_part(data[offset : offset + size]) for _, _, offset, size, _ in places]
    return Library(
        targets=frozenset.union(*(part.targets for part in parts)),
        exports=frozenset.intersection(*(part.exports for part in parts)),
        needs=tuple(dict.fromkeys(name for part in parts for name in part.needs)),
        unsigned=any(part.unsigned for part in parts),
    )


def _part(data: bytes) -> Library:
    wide = _THIN[data[:4]]
    _, number, _, kind, count = struct.unpack_from("<IIIII", data, 0)
    if kind not in _LIBRARIES:
        raise ValueError(f"Mach-O of type {kind} is no shared library")
    _checked(count, "load commands", MOST_COMMANDS)
    place = 32 if wide else 28
    exports: list[str] | None = None
    needs: list[str] = []
    signed = False
    for _ in range(count):
        command, size = struct.unpack_from("<II", data, place)
        if size < 8:
            raise ValueError(f"a load command of {size} bytes")
        if command == _SYMBOL_COMMAND and exports is None:
            table, symbols, strings = struct.unpack_from("<III", data, place + 8)
            exports = _mach_o_exports(data, table, symbols, strings, wide)
        elif command in _LOADS:
            (name,) = struct.unpack_from("<I", data, place + 8)
            needs.append(data[place + name : place + size].split(b"\0")[0].decode("latin-1"))
        signed = signed or command == _SIGNATURE
        place += size
    machine = _MACH_O_MACHINES.get(number, f"machine {number:#x}")
    unsigned = machine == "aarch64" and not signed
    targets = frozenset({f"{machine}-darwin"})
    return Library(targets, frozenset(exports or ()), tuple(dict.fromkeys(needs)), unsigned)


def _mach_o_exports(data: bytes, table: int, count: int, strings: int, wide: bool) -> list[str]:
    """Return the names of symbols that are defined and visible, without the leading underscore."""
    symbol = struct.Struct("<IBBHQ" if wide else "<IBBHI")
    found, names = [], Names(data)
    for k in range(_checked(count, "symbols")):
        name, kind, *_rest = symbol.unpack_from(data, table + k * symbol.size)
        visible = kind & _OUTSIDE and not kind & (_HIDDEN | _DEBUG)
        if visible and kind & _KIND == _DEFINED:
            found.append(names.at(strings + name).removeprefix("_"))
    return found


# Page size of arm64, as a power of two; each library begins at a multiple of it.
_ALIGNMENT = 14


def universal(libraries: Iterable[bytes]) -> bytes:
    """Join thin Mach-O libraries; one alone stays as it is. Source: Apple, mach-o/fat.h."""
    parts = list(libraries)
    if len(parts) == 1:
        return parts[0]
    page = 1 << _ALIGNMENT
    joined = struct.pack(">II", 0xCAFEBABE, len(parts))
    body = b""
    for part in parts:
        processor, variant = struct.unpack_from("<II", part, 4)
        place = page + len(body)
        joined += struct.pack(">IIIII", processor, variant, place, len(part), _ALIGNMENT)
        body += part + b"\0" * (-len(part) % page)
    return joined + b"\0" * (page - len(joined)) + body


_READERS = {_ELF: _read_elf, _PE: _read_pe, **dict.fromkeys((*_THIN, _FAT), _read_macho)}


def read_library(data: bytes) -> Library:
    """Read the headers of a shared library; NotALibrary for other formats and damaged ones."""
    try:
        for mark, read in _READERS.items():
            if data.startswith(mark):
                return read(data)
    except (struct.error, IndexError, ValueError, KeyError, OverflowError) as fault:
        raise NotALibrary(f"its headers are damaged: {fault}") from None
    raise NotALibrary(f"is neither ELF nor PE nor Mach-O; it begins with {data[:4]!r}")
