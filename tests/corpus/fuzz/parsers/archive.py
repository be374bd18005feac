"""Zip archives, unpacked into a folder of their own.

Whatever is accepted must lie below the folder, be plain files, and hold what was counted.
"""

from __future__ import annotations

import io
import shutil
import zlib
from dataclasses import replace
from pathlib import Path
from random import Random

from stickslip.fmi.archive.members import extract
from stickslip.fmi.archive.names import Refused
from tests.corpus.fuzz.mutation import TOKENS
from tests.corpus.hostile.zips import DEFLATE, FIFO, LINK, Member, zipped

EXPECTED = (Refused,)

_NAMES = (
    *(b"modelDescription.xml", b"binaries/linux64/a.so", b"resources/", b"resources/a/b/c.txt"),
    *(
        b"../out",
        b"/out",
        b"a/../../out",
        b"C:out",
        b"a\\b",
        b"con.txt",
        b"",
        b".",
        b"./a",
        b"a//b",
    ),
    *(
        b"MODELDESCRIPTION.XML",
        b"resources",
        b"a\0b",
        "\u00e4".encode(),
        b"\xff\xfe",
        b"a. ",
        b"d/" * 70,
    ),
    *(b"n" * 300, b"a:b", b"e\xcc\x81", b"\xc3\xa9", b"..", b"a/.", b"a/", b"\xe2\x80\xa8"),
)
_SIZES = (0, 1, 5, 99, 2**16 - 1, 2**31, 2**32 - 1)


def corpus() -> list[bytes]:
    plain = [Member(b"modelDescription.xml", b"<a/>" * 20, DEFLATE), Member(b"resources/a", b"a")]
    return [zipped(plain), zipped([]), zipped([Member(b"d/"), *plain], comment=b"hello")]


def parse(data: bytes, folder: Path) -> None:
    target = folder / "new"
    try:
        checks = extract(io.BytesIO(data), target)
        found = {p.relative_to(target).as_posix() for p in target.rglob("*") if not p.is_dir()}
        assert found == set(checks)
        assert all(zlib.crc32((target / n).read_bytes()) == check for n, check in checks.items())
    finally:
        shutil.rmtree(target, ignore_errors=True)
        assert not any(folder.iterdir())


def mutate(rng: Random, data: bytes) -> bytes:  # noqa: ARG001 - a new one each time
    """Return an archive of some members, of which few are as they should be."""
    members = [_member(rng) for _ in range(rng.randint(0, 4))]
    wrong = {}
    if rng.random() < 0.2:
        key = rng.choice(("before", "behind", "comment", "count", "directory", "length"))
        as_bytes = key in {"before", "behind", "comment"}
        wrong[key] = rng.choice(TOKENS) if as_bytes else rng.choice(_SIZES[:-3])
    return zipped(members, **wrong)


def _member(rng: Random) -> Member:
    content = rng.choice((b"", b"text", b"0" * 5000))
    member = Member(rng.choice(_NAMES[: rng.choice((4, len(_NAMES)))]), content, rng.choice((0, 8)))
    while rng.random() < 0.3:
        member = replace(member, **rng.choice(_LIES)(rng))
    return member


_LIES = (
    lambda rng: {"flags": 1 << rng.randrange(16)},
    lambda rng: {"method": rng.choice((1, 8, 9, 12, 14, 93, 99))},
    lambda rng: {"mode": rng.choice((LINK, FIFO, 0o060000, 0o040755, 0))},
    lambda rng: {"system": rng.randrange(256)},
    lambda rng: {"needs": rng.choice((0, 45, 63, 64, 255))},
    lambda rng: {"crc": rng.getrandbits(32)},
    lambda rng: {"size": rng.choice(_SIZES)},
    lambda rng: {"packed_size": rng.choice(_SIZES)},
    lambda rng: {"offset": rng.choice(_SIZES)},
    lambda rng: {"extra": rng.choice((b"\1\0\x10\0" + bytes(16), b"\1\0", b"up\x09\0\1aaaa../x"))},
    lambda rng: {"content": rng.randbytes(rng.randrange(50))},
    lambda rng: {"local": {"name": rng.choice(_NAMES)}},
    lambda rng: {"local": {rng.choice(("crc", "size", "packed")): rng.choice(_SIZES)}},
)
