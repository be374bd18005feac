"""What a shared library offers and what it needs: ELF, PE and Mach-O of 64 bit, little endian."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from struct import unpack_from

from stickslip.fmi.binary.names import MOST_COMMANDS, MOST_NAMES, MOST_SECTIONS, Names, checked
from stickslip.fmi.errors import Fault


class NotALibrary(Fault, ValueError):
    """The bytes are not a shared library that can be read."""


@dataclass(frozen=True)
class Interface:
    """The names a library exports, and the file names of the libraries it needs."""

    exports: frozenset[str]
    needs: frozenset[str]


def interface(library: bytes) -> Interface:
    """Read the interface of one library.

    Raises
    ------
    NotALibrary
        When the bytes are of none of the three formats or end too early.
    """
    try:
        if library[:4] == b"\x7fELF":
            exports, needs = _elf(library)
        elif library[:2] == b"MZ":
            exports, needs = _pe(library)
        elif library[:4] == b"\xcf\xfa\xed\xfe":
            exports, needs = _mach_o(library)
        else:
            raise NotALibrary(f"neither ELF nor PE nor Mach-O: it begins with {library[:4]!r}")
    except (struct.error, ValueError, IndexError, OverflowError) as error:
        raise NotALibrary(f"a damaged library: {error}") from None
    return Interface(frozenset(exports), frozenset(needs))


def _elf(data: bytes) -> tuple[list[str], list[str]]:
    """Read the sections .dynsym (type 11) and .dynamic (type 6), each linked to its strings."""
    (table,) = unpack_from("<Q", data, 40)
    size, count = unpack_from("<HH", data, 58)
    sections = [unpack_from("<IIQQQQI", data, table + k * size) for k in range(count)]
    first = {section[1]: section[4:] for section in reversed(sections)}
    exports, needs, names = [], [], Names(data)
    for offset, length, link in [first[11]] if 11 in first else []:
        for k in range(checked(length // 24, "symbols")):
            name, info, _, section = unpack_from("<IBBH", data, offset + 24 * k)
            if section and info >> 4 in (1, 2):  # defined here, global or weak
                exports.append(names.at(sections[link][4] + name))
    for offset, length, link in [first[6]] if 6 in first else []:
        for k in range(checked(length // 16, "entries in .dynamic", MOST_COMMANDS)):
            tag, value = unpack_from("<QQ", data, offset + 16 * k)
            if tag == 1:
                needs.append(names.at(sections[link][4] + value))
    return exports, needs


def _pe(data: bytes) -> tuple[list[str], list[str]]:
    """Read the first two data directories: exports and imports."""
    (header,) = unpack_from("<I", data, 60)
    (count,) = unpack_from("<H", data, header + 6)
    (optional,) = unpack_from("<H", data, header + 20)
    first = header + 24 + optional
    sections: list[tuple[int, ...]] = [
        unpack_from("<IIII", data, first + 40 * k + 8)
        for k in range(checked(count, "sections", MOST_SECTIONS))
    ]

    def place(address: int) -> int:
        for size, start, _, offset in sections:
            if start <= address < start + size:
                return address - start + offset
        raise ValueError(f"no section holds address {address}")

    exported, _, imported = unpack_from("<III", data, header + 24 + 112)
    exports, needs, names = [], [], Names(data)
    if exported:
        n, _, table = unpack_from("<III", data, place(exported) + 24)
        for k in range(checked(n, "exported names", MOST_NAMES)):
            (name,) = unpack_from("<I", data, place(table) + 4 * k)
            exports.append(names.at(place(name)))
    k = place(imported) if imported else 0
    while k and (name := unpack_from("<I", data, k + 12)[0]):
        needs.append(names.at(place(name)))
        checked(len(needs), "libraries that it needs", MOST_NAMES)
        k += 20
    return exports, needs


def _mach_o(data: bytes) -> tuple[list[str], list[str]]:
    """Read the load commands LC_SYMTAB (2) and LC_LOAD_DYLIB (12); C names begin with _."""
    commands = list(_load_commands(data))
    exports, needs, names = [], [], Names(data)
    for k in [k for kind, k in commands if kind == 2][:1]:  # there is one
        symbols, count, strings, _ = unpack_from("<IIII", data, k + 8)
        for s in range(symbols, symbols + 16 * checked(count, "symbols"), 16):
            name, flags = unpack_from("<IB", data, s)
            if flags & 0x0F == 0x0F:  # external, in a section; not private
                exports.append(names.at(strings + name).removeprefix("_"))
    for k in (k for kind, k in commands if kind == 12):
        (name,) = unpack_from("<I", data, k + 8)
        needs.append(names.at(k + name))
    return exports, needs


def _load_commands(data: bytes) -> Iterator[tuple[int, int]]:
    (count,) = unpack_from("<I", data, 16)
    k = 32
    for _ in range(checked(count, "load commands", MOST_COMMANDS)):
        kind, size = unpack_from("<II", data, k)
        if size < 8:
            raise ValueError(f"a load command of {size} bytes")
        yield kind, k
        k += size
