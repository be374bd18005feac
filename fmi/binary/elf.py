"""Linux: ELF. Read through the dynamic segment, which stripping leaves alone."""

from __future__ import annotations

import struct
from collections.abc import Callable

from stickslip.fmi.binary.names import MOST_COMMANDS, Names, checked

MAGIC = b"\x7fELF"

_MACHINES = {0x03: "x86", 0x3E: "x86_64", 0x28: "aarch32", 0xB7: "aarch64", 0xF3: "riscv"}
_LOAD, _DYNAMIC, _SHARED = 1, 2, 3
_NEEDED, _HASH, _STRINGS, _SYMBOLS, _GNU_HASH = 1, 4, 5, 6, 0x6FFFFEF5


def read(data: bytes) -> tuple[str, list[str], list[str]]:
    """Return machine, exported names and needed libraries."""
    wide, order = data[4] == 2, "<" if data[5] == 1 else ">"
    kind, number = struct.unpack_from(order + "HH", data, 16)
    if kind != _SHARED:
        raise ValueError(f"ELF of type {kind} is no shared library")
    segments = _segments(data, wide, order)
    loads = [(address, offset, size) for what, offset, address, size in segments if what == _LOAD]
    dynamic = next(((offset, size) for what, offset, _, size in segments if what == _DYNAMIC), None)
    if dynamic is None:
        raise ValueError("it has no dynamic segment")
    entry = struct.Struct(order + ("qQ" if wide else "iI"))
    length = checked(dynamic[1] // entry.size, "entries in the dynamic segment", MOST_COMMANDS)
    entries = [entry.unpack_from(data, dynamic[0] + k * entry.size) for k in range(length)]
    tags = dict(reversed(entries))

    def offset(address: int) -> int:
        for start, place, size in loads:
            if start <= address < start + size:
                return place + address - start
        raise ValueError(f"address {address:#x} lies in no segment")

    strings, names = offset(tags[_STRINGS]), Names(data)
    needs = [names.at(strings + value) for tag, value in entries if tag == _NEEDED]
    count = checked(_symbol_count(data, tags, offset, order, wide), "symbols")
    exports = _exports(data, offset(tags[_SYMBOLS]), count, order, wide)
    machine = _MACHINES.get(number, f"machine {number}")
    return machine, [names.at(strings + name) for name in exports], needs


def _segments(data: bytes, wide: bool, order: str) -> list[tuple[int, int, int, int]]:
    """Return type, offset, address and size in the file of each segment."""
    if wide:
        (table,) = struct.unpack_from(order + "Q", data, 32)
        size, count = struct.unpack_from(order + "HH", data, 54)
    else:
        (table,) = struct.unpack_from(order + "I", data, 28)
        size, count = struct.unpack_from(order + "HH", data, 42)
    found = []
    for k in range(count):
        place = table + k * size
        if wide:
            what, _, at, address, _, length = struct.unpack_from(order + "IIQQQQ", data, place)
        else:
            what, at, address, _, length = struct.unpack_from(order + "IIIII", data, place)
        found.append((what, at, address, length))
    return found


def _symbol_count(
    data: bytes, tags: dict[int, int], offset: Callable[[int], int], order: str, wide: bool
) -> int:
    if _HASH in tags:
        return int(struct.unpack_from(order + "I", data, offset(tags[_HASH]) + 4)[0])
    table = offset(tags[_GNU_HASH])
    buckets, first, bloom, _ = struct.unpack_from(order + "IIII", data, table)
    place = table + 16 + bloom * (8 if wide else 4)
    checked(buckets, "buckets of symbols")
    last = max(struct.unpack_from(f"{order}{buckets}I", data, place), default=0)
    if last < first:
        return int(first)
    chain = place + 4 * buckets + 4 * (last - first)
    while not struct.unpack_from(order + "I", data, chain)[0] & 1:
        chain, last = chain + 4, checked(last + 1, "symbols")
    return int(last) + 1


def _exports(data: bytes, table: int, count: int, order: str, wide: bool) -> list[int]:
    """Return places in the string table of the symbols that are defined and visible."""
    symbol = struct.Struct(order + ("IBBHQQ" if wide else "IIIBBH"))
    found = []
    for k in range(count):
        fields = symbol.unpack_from(data, table + k * symbol.size)
        name, info, section = (
            (fields[0], fields[1], fields[3]) if wide else (fields[0], fields[3], fields[5])
        )
        if section and info >> 4 in (1, 2):  # global or weak
            found.append(name)
    return found
