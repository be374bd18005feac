"""Shared libraries of all systems, read without being loaded: exports and needed libraries."""

from __future__ import annotations

import struct
from pathlib import Path
from random import Random

from stickslip.fmi import toolchain
from stickslip.fmi.binary import NotALibrary, read_library, universal

_CODE = '__attribute__((visibility("default"))) double twice(double x) { return x + x; }\n'
_NUMBERS = (0, 1, 7, 8, 24, 255, 2**15, 2**16 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1)


EXPECTED = NotALibrary


def corpus() -> list[bytes]:
    each = {
        name: toolchain.shared_library(
            "twice", {"a.c": _CODE}, platform=platform, standalone=True
        ).read_bytes()
        for name, platform in toolchain.PLATFORMS.items()
    }
    apple = [data for name, data in each.items() if "darwin" in name]
    return [*each.values(), universal(apple)]


def parse(data: bytes, folder: Path) -> None:  # noqa: ARG001 - nothing is written
    read_library(data)


def mutate(rng: Random, data: bytes) -> bytes:
    """Return it with some numbers of its headers and tables changed."""
    changed = bytearray(data)
    used = [place for place in range(0, len(data) - 8, 4) if data[place : place + 4] != bytes(4)]
    for _ in range(rng.randint(1, 4)):
        place = rng.choice(used[: rng.choice((40, 400, len(used)))])
        size = rng.choice("BHIQ")
        near = struct.unpack_from(f"<{size}", data, place)[0] + rng.randint(-9, 9)
        value = rng.choice((near, rng.choice(_NUMBERS), len(data) - rng.randrange(64)))
        struct.pack_into(f"<{size}", changed, place, value % 2 ** (8 * struct.calcsize(size)))
    return bytes(changed)
