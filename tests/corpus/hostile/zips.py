"""Zip archives written field by field, so that each can lie.

Source: PKWARE's APPNOTE, sections 4.3.7 (local header), 4.3.12 (directory), 4.3.16 (end).
"""

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

STORED, DEFLATE, UTF8 = 0, 8, 0x800
UNIX = 3
LINK, FIFO, FILE = 0o120777, 0o010666, 0o100644


@dataclass(frozen=True)
class Member:
    """A member; what is None is as it should be.

    ``local`` overrides fields of the local header alone: ``name``, ``crc``, ``size``, ``packed``.
    """

    name: bytes
    data: bytes = b""
    method: int = STORED
    flags: int = 0
    mode: int = FILE
    system: int = UNIX
    needs: int = 20
    crc: int | None = None
    size: int | None = None
    packed_size: int | None = None
    offset: int | None = None
    extra: bytes = b""
    content: bytes | None = None  # in place of the packed data
    local: dict[str, object] = field(default_factory=dict)

    @cached_property
    def packed(self) -> bytes:
        if self.content is not None:
            return self.content
        if self.method != DEFLATE:
            return self.data
        deflate = zlib.compressobj(9, wbits=-15)
        return deflate.compress(self.data) + deflate.flush()

    def _fields(self) -> tuple[int, ...]:
        packed = len(self.packed) if self.packed_size is None else self.packed_size
        size = len(self.data) if self.size is None else self.size
        crc = zlib.crc32(self.data) if self.crc is None else self.crc
        return self.flags, self.method, 0, 0x21, crc, packed, size

    def head(self) -> bytes:
        flags, method, clock, day, crc, packed, size = self._fields()
        local = {"name": self.name, "crc": crc, "size": size, "packed": packed} | self.local
        return (
            struct.pack(
                "<4s5H3L2H",
                *(b"PK\3\4", self.needs, flags, method, clock, day),
                *(local["crc"], local["packed"], local["size"]),
                *(len(local["name"]), len(self.extra)),
            )
            + local["name"]
            + self.extra
        )

    def entry(self, offset: int) -> bytes:
        at = offset if self.offset is None else self.offset
        head = struct.pack(
            "<4s2B5H3L5H2L",
            *(b"PK\1\2", 20, self.system, self.needs, *self._fields()),
            *(len(self.name), len(self.extra), 0, 0, 0, self.mode << 16, at),
        )
        return head + self.name + self.extra


def zipped(
    members: Sequence[Member],
    *,
    before: bytes = b"",
    comment: bytes = b"",
    count: int | None = None,
    directory: int | None = None,
    length: int | None = None,
) -> bytes:
    """Return an archive; its end says number of members, and place and length of their list."""
    body, entries = bytearray(), bytearray()
    for member in members:
        entries += member.entry(len(body))
        body += member.head() + member.packed
    n = len(members) if count is None else count
    end = struct.pack(
        "<4s4H2LH",
        *(b"PK\5\6", 0, 0, n, n),
        len(entries) if length is None else length,
        len(body) if directory is None else directory,
        len(comment),
    )
    return b"".join((before, body, entries, end, comment))
