"""macOS: Mach-O, one processor or several in a universal file."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from stickslip.fmi.binary.names import MOST_COMMANDS, Names, checked

_THIN = {b"\xcf\xfa\xed\xfe": True, b"\xce\xfa\xed\xfe": False}
_FAT = b"\xca\xfe\xba\xbe"
MAGICS = (*_THIN, _FAT)

_MACHINES = {7: "x86", 0x01000007: "x86_64", 12: "aarch32", 0x0100000C: "aarch64"}
_LIBRARIES = (6, 8)  # dylib and bundle
_SYMBOLS, _SIGNATURE = 0x2, 0x1D
_LOADS = (0xC, 0x80000018, 0x8000001F, 0x23 | 0x80000000)  # plain, weak, re-exported, upward
_OUTSIDE, _HIDDEN, _KIND, _DEFINED, _DEBUG = 0x01, 0x10, 0x0E, 0x0E, 0xE0


@dataclass(frozen=True)
class Part:
    """The part for one processor."""

    machine: str
    exports: list[str]
    needs: list[str]
    signed: bool


def read(data: bytes) -> list[Part]:
    """Return the parts of a library."""
    if data[:4] != _FAT:
        return [_part(data)]
    (count,) = struct.unpack_from(">I", data, 4)
    if not 0 < count < 20:  # a Java class begins with the same four bytes
        raise ValueError(f"a universal file with {count} parts")
    places = [struct.unpack_from(">IIIII", data, 8 + 20 * k) for k in range(count)]
    return [_part(data[offset : offset + size]) for _, _, offset, size, _ in places]


def _part(data: bytes) -> Part:
    wide = _THIN[data[:4]]
    _, number, _, kind, count = struct.unpack_from("<IIIII", data, 0)
    if kind not in _LIBRARIES:
        raise ValueError(f"Mach-O of type {kind} is no shared library")
    checked(count, "load commands", MOST_COMMANDS)
    place = 32 if wide else 28
    exports: list[str] | None = None
    needs: list[str] = []
    signed = False
    for _ in range(count):
        command, size = struct.unpack_from("<II", data, place)
        if size < 8:
            raise ValueError(f"a load command of {size} bytes")
        if command == _SYMBOLS and exports is None:
            table, symbols, strings = struct.unpack_from("<III", data, place + 8)
            exports = _exports(data, table, symbols, strings, wide)
        elif command in _LOADS:
            (name,) = struct.unpack_from("<I", data, place + 8)
            needs.append(data[place + name : place + size].split(b"\0")[0].decode("latin-1"))
        signed = signed or command == _SIGNATURE
        place += size
    return Part(_MACHINES.get(number, f"machine {number:#x}"), exports or [], needs, signed)


def _exports(data: bytes, table: int, count: int, strings: int, wide: bool) -> list[str]:
    """Return the names of symbols that are defined and visible, without the leading underscore."""
    symbol = struct.Struct("<IBBHQ" if wide else "<IBBHI")
    found, names = [], Names(data)
    for k in range(checked(count, "symbols")):
        name, kind, *_rest = symbol.unpack_from(data, table + k * symbol.size)
        visible = kind & _OUTSIDE and not kind & (_HIDDEN | _DEBUG)
        if visible and kind & _KIND == _DEFINED:
            found.append(names.at(strings + name).removeprefix("_"))
    return found
