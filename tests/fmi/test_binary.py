"""What a library exports and needs, read from its bytes, for every platform."""

import struct

import pytest

from stickslip.fmi import toolchain
from stickslip.fmi.binary import Names, NotALibrary, read_library, universal
from stickslip.fmi.toolchain import PLATFORMS
from tests.corpus.fmu import EXPORT
from tests.kept import further

SOURCE = {
    "two.c": f"""{EXPORT}
#include <string.h>
EXPORT int one(void);
EXPORT void two(void *a, const void *b, unsigned n);
int hidden(void);
int hidden(void) {{ return 2; }}
int one(void) {{ return hidden() - 1; }}
void two(void *a, const void *b, unsigned n) {{ memcpy(a, b, n); }}
"""
}
NEEDS = {
    "x86_64-linux": {"libc.so.6"},
    "aarch64-linux": {"libc.so.6"},
    "x86_64-windows": set(),
    "x86_64-darwin": {"/usr/lib/libSystem.B.dylib"},
    "aarch64-darwin": {"/usr/lib/libSystem.B.dylib"},
}


def build(platform: str, exports: set[str] | None = None) -> bytes:
    return toolchain.shared_library(
        "two", SOURCE, platform=PLATFORMS[platform], standalone=True, exports=exports
    ).read_bytes()


@pytest.mark.parametrize("platform", PLATFORMS)
def test_exports_and_needs_are_read_from_every_format(platform):
    found = read_library(build(platform, {"one", "two"}))
    assert found.exports - {"__dso_handle", "_mh_dylib_header"} == {"one", "two"}
    assert set(found.needs) == NEEDS[platform]
    assert found.targets == {platform}
    assert not found.unsigned


@pytest.mark.parametrize(
    "platform",
    [
        *("x86_64-linux", "x86_64-windows", "x86_64-darwin"),
        *further("aarch64-linux", "aarch64-darwin"),
    ],
)
def test_an_export_too_few_or_too_many_is_an_error(platform, tmp_path, monkeypatch):
    (tmp_path / "zig").symlink_to(toolchain.cache_directory() / "zig")
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path))
    with pytest.raises(toolchain.WrongExports, match="does not export three"):
        build(platform, {"one", "two", "three"})
    with pytest.raises(toolchain.WrongExports, match="exports two, not expected of it"):
        build(platform, {"one"})
    assert not list(tmp_path.glob("libraries/*/*"))


def test_a_universal_library_holds_both_processors_whole():
    thin = [build(name) for name in ("x86_64-darwin", "aarch64-darwin")]
    joined = universal(thin)
    magic, count = struct.unpack_from(">II", joined)
    assert (magic, count) == (0xCAFEBABE, 2)
    for k, (part, processor) in enumerate(zip(thin, (0x01000007, 0x0100000C), strict=True)):
        kind, _, place, size, align = struct.unpack_from(">IIIII", joined, 8 + 20 * k)
        assert kind == processor
        assert place % (1 << align) == 0
        assert joined[place : place + size] == part
    assert universal(thin[:1]) == thin[0]
    library = read_library(joined)
    assert library.targets == {"x86_64-darwin", "aarch64-darwin"}
    assert {"one", "two"} <= library.exports


def test_names_end_soon_and_are_not_without_number():
    assert Names(b"ab\0c\0").at(1) == "b"
    with pytest.raises(ValueError, match="does not end within 4096"):
        Names(b"x" * 5000 + b"\0").at(0)
    names = Names(b"x" * 4000 + b"\0")
    with pytest.raises(ValueError, match="names of more than"):
        [names.at(0) for _ in range(10_000)]  # as tables whose entries all point to one name


def words(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}I", *numbers)


MACHO = words(0xFEEDFACF, 0x01000007, 3, 6)
ENDLESS = {
    "commands of no size": MACHO + words(2**32 - 1, 0, 0, 0) + bytes(64),
    "commands": MACHO + words(2**32 - 1, 0, 0, 0) + words(99, 8) * 20_000,
    "symbols": MACHO + words(1, 24, 0, 0) + words(2, 24, 0, 2**31, 0, 0) + bytes(16 * 600_000),
    "sections": b"MZ".ljust(60, b"\0") + words(64) + b"PE\0\0"
    # machine, sections, two dates, symbols, the optional header's size, flags
    + struct.pack("<HHIIIHH", 0x8664, 65535, 0, 0, 0, 240, 0x2000) + bytes(40 * 65535 + 240),
}  # fmt: skip


@pytest.mark.parametrize("name", ENDLESS)
def test_tables_without_end_are_not_read(name):
    with pytest.raises(NotALibrary, match=r"are read|of 0 bytes"):
        read_library(ENDLESS[name])
