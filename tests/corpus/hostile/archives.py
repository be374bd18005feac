"""Archives: names that leave their folder, links, bombs, damage."""

from pathlib import Path

from tests.corpus.hostile.case import Case
from tests.corpus.hostile.sound import DESCRIPTION, fmu, members
from tests.corpus.hostile.zips import DEFLATE, FIFO, LINK, UTF8, Member, zipped

_MB = 1024**2


def _beside(group: int, name: str, about: str, says: str, *more: Member) -> Case:
    """Return a case of a sound FMU that has further members."""
    return fmu(group, name, about, says, lambda: zipped([*members(), *more]))


def _named(name: str, about: str, says: str, *members: bytes) -> Case:
    more = (Member(m, b"" if m.endswith(b"/") else b"evil", flags=UTF8) for m in members)
    return _beside(1, name, about, says, *more)


_NAMES = [
    _named("up", "../../evil", "would leave the folder", b"../../evil"),
    _named("absolute", "/etc/evil", "would leave the folder", b"/etc/evil"),
    _named("drive-relative", "C:evil", "would leave the folder", b"C:evil"),
    _named("backslash", "..\\evil", "backslash", b"..\\evil"),
    _named("nul-in-name", "a NUL in the name", "control characters", b"a.txt\0.so"),
    _named("nameless-member", "no name at all", "empty part", b""),
    _named("long-name", "a name of 300 bytes", "path of 300 bytes", b"n" * 300),
    _named("deep-folders", "100 folders deep", "folders deep|path of", b"d/" * 100 + b"a"),
    _beside(1, "twice", "two files of one name", "occurs twice", Member(b"a.txt", b"evil"), Member(b"a.txt", b"good")),
    _named("file-and-folder", "a file that others lie in", "a folder of other", b"a", b"a/b"),
    _named("file-as-folder", "a file and a folder of one name", "a folder of other", b"a", b"a/"),
    _named("dot", "a file that is the folder", "names a folder", b"."),
]  # fmt: skip

_LINKS = [
    _beside(2, "link-out", "a link to a file outside", "link", Member(b"a", b"/etc", mode=LINK)),
    fmu(2, "linked-description", "the description is a link", "symbolic link", lambda: zipped([Member(DESCRIPTION.encode(), b"/etc/passwd", mode=LINK), *members(2, [DESCRIPTION])])),
    _beside(2, "pipe", "a named pipe", "special file", Member(b"pipe", mode=FIFO)),
]  # fmt: skip


_BOMBS = [
    fmu(3, "ratio", "70 MB of zeros in 70 kB", "zip bomb", lambda: zipped([*members(), Member(b"zeros", bytes(70 * _MB), DEFLATE)])),
    _beside(3, "claims", "3 GB, says the header", "3000000000 bytes", Member(b"a", size=3 * 10**9)),
    fmu(3, "lies", "20 MB, though the header says 1 kB", "damaged", lambda: zipped([*members(), Member(b"zeros", bytes(20 * _MB), DEFLATE, size=1000)])),
    _beside(3, "short", "fewer bytes than the header says", "damaged", Member(b"a", b"a", 8, size=9)),
    fmu(3, "members", "30,000 members", "at most 20000", lambda: zipped([Member(b"%d" % i) for i in range(30_000)])),
    fmu(3, "overlap", "a hundred members over the same bytes", "overlap", lambda: zipped([*members(), *(Member(b"%d" % i, b"a" * 99, offset=0) for i in range(100))])),
    _beside(3, "full-folder", "a folder with content", "folder with", Member(b"a/", b"text")),
    fmu(3, "nested", "zip in zip in zip, an FMU at the bottom", "modelDescription.xml is missing", lambda: zipped([Member(b"a.zip", zipped([Member(b"b.zip", zipped(members()))]))])),
]  # fmt: skip


def _sound() -> bytes:
    return zipped(members())


def _flipped() -> bytes:
    data = bytearray(_sound())
    data[len(data) // 2] ^= 0xFF
    return bytes(data)


def _odd(name: str, about: str, says: str, **fields: object) -> Case:
    return _beside(4, name, about, says, Member(b"a", b"text", **fields))


_DAMAGED = [
    fmu(4, "empty-file", "a file of 0 bytes", "the file is empty", bytes),
    fmu(4, "plain-text", "no archive", "not a zip archive", lambda: b"this is no archive\n" * 99),
    fmu(4, "half", "cut off in the middle", "end is missing", lambda: _sound()[:5000]),
    fmu(4, "flipped", "a byte is another", "damaged", _flipped),
    fmu(4, "text-before", "text before it", "20 bytes before", lambda: b"#!/bin/sh\nexit 0   \n" + _sound()),
    fmu(4, "text-behind", "text behind it", "5 bytes behind", lambda: _sound() + b"later"),
    fmu(4, "short-comment", "a comment cut off", "bytes missing at the end", lambda: zipped([], comment=b"abc")[:-1]),
    fmu(4, "no-members", "an archive of nothing", "is missing", lambda: zipped([])),
    fmu(4, "count", "the end counts wrongly", "stated", lambda: zipped(members(), count=7)),
    fmu(4, "place", "the end points elsewhere", "before", lambda: zipped(members(), directory=9)),
    fmu(4, "length", "a list that is too long", "missing", lambda: zipped(members(), length=10**6)),
    fmu(4, "zip64", "sizes that only a zip64 has", "4294967295 bytes", lambda: zipped(members(), length=2**32 - 1)),
    _odd("checksum", "a wrong checksum", "damaged: Bad CRC", crc=1),
    _odd("encrypted", "a member with a password", "is encrypted; pack it without", flags=1),
    _odd("patch", "compressed patched data", "patched", flags=0x20),
    _odd("bzip2", "packed by bzip2", "method 12", method=12),
    _odd("no-deflate", "text that is said to be packed", "damaged", method=8, content=b"text"),
    _odd("version", "needs zip 25.5", "version 25.5|zip file version", needs=255),
    _odd("two-names", "other names within than in the list", "damaged", local={"name": b"b"}),
    _odd("extra", "a broken extra field", "extra", extra=b"\1\0\xff\xff"),
    _odd("offset", "a member behind the end", "damaged|overlap", offset=2**31),
    Case(4, "folder", "a folder called .fmu", "is no file", "simulate a.fmu", {"a.fmu": Path.mkdir}),
]  # fmt: skip

CASES = [*_NAMES, *_LINKS, *_BOMBS, *_DAMAGED]
