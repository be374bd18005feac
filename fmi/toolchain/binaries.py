"""The libraries of an FMU for several platforms, and data written into them."""

import hashlib
import os
import re
import struct
from collections.abc import Callable, Iterable
from pathlib import Path

from stickslip.fmi.binary import universal
from stickslip.fmi.process.threads import Threads
from stickslip.fmi.toolchain.compiler import vouch
from stickslip.fmi.toolchain.platforms import Platform, ToolchainError

_MACH_O = b"\xcf\xfa\xed\xfe"
_CODE_SIGNATURE = 0x1D  # the load command
_CODE_DIRECTORY = 0xFADE0C02
_SHA256 = 2


def patched(library: bytes, marker: bytes, content: bytes) -> bytes:
    """Return a library with other bytes behind a marker that it has once, and with new hashes."""
    if library.count(marker) != 1:
        raise ToolchainError(f"the library contains {marker!r} {library.count(marker)} times")
    begin = library.index(marker) + len(marker)
    end = begin + len(content)
    changed = bytearray(library)
    changed[begin:end] = content
    if library.startswith(_MACH_O):
        _sign(changed, begin, end)
    return bytes(changed)


def _sign(library: bytearray, begin: int, end: int) -> None:
    """Renew the hashes of pages from begin to end. Source: cs_blobs.h, loader.h of Apple's XNU."""
    place = 32
    for _ in range(*struct.unpack_from("<I", library, 16)):
        command, size, offset = struct.unpack_from("<III", library, place)
        if command == _CODE_SIGNATURE:
            break
        place += size
    else:
        return
    for k in range(*struct.unpack_from(">I", library, offset + 8)):
        directory = offset + struct.unpack_from(">I", library, offset + 16 + 8 * k)[0]
        magic, _, _, _, hashes, _, _, count, limit = struct.unpack_from(">9I", library, directory)
        if magic != _CODE_DIRECTORY:
            continue
        width, kind, _, exponent = struct.unpack_from("4B", library, directory + 36)
        if kind != _SHA256:
            raise ToolchainError(f"the library is signed with hashes of kind {kind}; expected 2")
        page = 1 << exponent
        for number in range(begin // page, min(count, -(-end // page))):
            content = library[number * page : min(limit, (number + 1) * page)]
            at = directory + hashes + width * number
            library[at : at + width] = hashlib.sha256(content).digest()[:width]


def standard_functions(header: str) -> list[str]:
    """Return what every FMU of a standard exports, as its ``fmi?Functions.h`` says."""
    return re.findall(r"^ *FMI._Export +\w+ +(\w+);", header, re.MULTILINE)


def binaries(
    name: str,
    fmi: int,
    platforms: Iterable[Platform],
    build: Callable[[Platform], Path],
    change: Callable[[bytes], bytes] | None = None,
) -> dict[str, bytes]:
    """Build for all platforms side by side; return path in the FMU -> library.

    Platforms that share a folder in FMI 2.0 share a universal library. ``name`` is what libraries
    are called, without ending, and ``change`` returns what becomes of the content of one.
    """
    targets = list(platforms)
    parts: dict[str, list[bytes]] = {}
    with Threads(os.cpu_count()) as pool:
        for platform, library in zip(targets, pool.each(build, targets), strict=True):
            folder = platform.fmi2 if fmi == 2 else platform.tuple
            content = library.read_bytes()
            if change is not None:
                content = change(content)
                vouch(hashlib.sha256(content).hexdigest())
            parts.setdefault(f"binaries/{folder}/{name}{platform.suffix}", []).append(content)
    return {path: universal(libraries) for path, libraries in parts.items()}
