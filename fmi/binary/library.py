"""The headers of a shared library, in any of the three formats."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from stickslip.fmi.binary import elf, macho, pe
from stickslip.fmi.errors import Fault


class NotALibrary(Fault, ValueError):
    """The bytes are not a shared library that can be read."""


@dataclass(frozen=True)
class Library:
    """One shared library.

    Attributes
    ----------
    targets : platforms it runs on, such as ``x86_64-linux``; several in a universal file of macOS
    exports : names of the functions that can be loaded from it
    needs : file names of the libraries it loads itself
    unsigned : a part for arm64 macOS has no signature, without which it is not loaded
    """

    targets: frozenset[str]
    exports: frozenset[str]
    needs: tuple[str, ...]
    unsigned: bool = False


def read_library(data: bytes) -> Library:
    """Read the headers of a shared library.

    Raises
    ------
    NotALibrary
        When the bytes are of none of the three formats, or their headers are damaged.
    """
    try:
        if data[:4] == elf.MAGIC:
            machine, exports, needs = elf.read(data)
            return Library(frozenset({f"{machine}-linux"}), frozenset(exports), tuple(needs))
        if data[:2] == pe.MAGIC:
            machine, exports, needs = pe.read(data)
            return Library(frozenset({f"{machine}-windows"}), frozenset(exports), tuple(needs))
        if data[:4] in macho.MAGICS:
            parts = macho.read(data)
            return Library(
                targets=frozenset(f"{part.machine}-darwin" for part in parts),
                exports=frozenset.intersection(*(frozenset(part.exports) for part in parts)),
                needs=tuple(dict.fromkeys(name for part in parts for name in part.needs)),
                unsigned=any(part.machine == "aarch64" and not part.signed for part in parts),
            )
    except (struct.error, IndexError, ValueError, KeyError, OverflowError) as fault:
        raise NotALibrary(f"its headers are damaged: {fault}") from None
    raise NotALibrary(f"is neither ELF nor PE nor Mach-O; it begins with {data[:4]!r}")
