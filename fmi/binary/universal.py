"""Libraries of several processors in one file: the universal binary of macOS."""

from __future__ import annotations

import struct
from collections.abc import Iterable

# Page size of arm64, as a power of two; each library begins at a multiple of it.
_ALIGNMENT = 14


def universal(libraries: Iterable[bytes]) -> bytes:
    """Join thin Mach-O libraries; one alone stays as it is.

    Source
    ------
    Apple, mach-o/fat.h: a header of big-endian words, one entry a processor, then the libraries.
    """
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
