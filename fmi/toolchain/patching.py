"""Data written into a compiled library, without compiling it again."""

from __future__ import annotations

import hashlib
import struct

from stickslip.fmi.toolchain.errors import ToolchainError

_MACH_O = b"\xcf\xfa\xed\xfe"
_CODE_SIGNATURE = 0x1D  # the load command
_CODE_DIRECTORY = 0xFADE0C02
_SHA256 = 2


def patched(library: bytes, marker: bytes, content: bytes) -> bytes:
    """Return a library with other bytes behind a marker, and with the hashes of its signature.

    Raises
    ------
    ToolchainError
        When it does not contain the marker once.
    """
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
    """Renew the hashes of the pages that have bytes from begin to end, where there are any.

    Source
    ------
    cs_blobs.h and loader.h of Apple's XNU: a superblob with a code directory, in big-endian.
    """
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
