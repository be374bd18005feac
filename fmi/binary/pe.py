"""Windows: PE, also called COFF."""

from __future__ import annotations

import struct

from stickslip.fmi.binary.names import MOST_NAMES, MOST_SECTIONS, Names, checked

MAGIC = b"MZ"

_MACHINES = {0x14C: "x86", 0x8664: "x86_64", 0xAA64: "aarch64", 0x1C4: "aarch32"}
_IS_DLL = 0x2000


def read(data: bytes) -> tuple[str, list[str], list[str]]:
    """Return machine, exported names and needed libraries."""
    (header,) = struct.unpack_from("<I", data, 0x3C)
    if data[header : header + 4] != b"PE\0\0":
        raise ValueError("it has no PE header")
    number, sections, _, _, _, optional, flags = struct.unpack_from("<HHIIIHH", data, header + 4)
    if not flags & _IS_DLL:
        raise ValueError("it is a program, not a library")
    checked(sections, "sections", MOST_SECTIONS)
    start = header + 24
    (magic,) = struct.unpack_from("<H", data, start)
    directories = start + (112 if magic == 0x20B else 96)
    parts = [
        struct.unpack_from("<8sIIII", data, start + optional + 40 * k) for k in range(sections)
    ]

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
        checked(count, "exported names", MOST_NAMES)
        addresses = struct.unpack_from(f"<{count}I", data, offset(table)) if count else ()
        exports = [names.at(offset(address)) for address in addresses]
    (imported,) = struct.unpack_from("<I", data, directories + 8)
    if imported:
        place = offset(imported)
        while name := struct.unpack_from("<I", data, place + 12)[0]:
            needs.append(names.at(offset(name)))
            checked(len(needs), "libraries that it needs", MOST_NAMES)
            place += 20
    return _MACHINES.get(number, f"machine {number:#x}"), exports, needs
