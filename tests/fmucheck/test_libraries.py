"""Shared libraries are read as they are, whatever they are built for."""

import struct
import zipfile

import pytest

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.fmi.binary import NotALibrary, read_library, universal
from stickslip.fmucheck import check
from tests.corpus.defects.reference import pack

# Windows is left out: its C library takes minutes to build on a cold cache.
NAMES = [name for name in toolchain.PLATFORMS if "windows" not in name]
CODE = """
#include <math.h>
__attribute__((visibility("default"))) double shown(double x) { return hidden_of(x) + exp(x); }
"""
FILES = {"a.h": "double hidden_of(double x);\n", "b.c": "double hidden_of(double x){return x;}\n"}
FILES["b.c"] = '#include "a.h"\n' + FILES["b.c"]
FILES["a.c"] = '#include "a.h"\n' + CODE


def built(name: str) -> bytes:
    return toolchain.shared_library("pair", FILES, platform=toolchain.PLATFORMS[name]).read_bytes()


@pytest.mark.parametrize("name", NAMES)
def test_target_exports_and_needs(name):
    library = read_library(built(name))
    assert library.targets == {name}
    assert "shown" in library.exports
    assert "hidden_of" not in library.exports
    assert not library.unsigned
    assert any("libm" in needed or "libSystem" in needed for needed in library.needs)


def test_windows_by_hand():
    """A DLL put together byte by byte: one export, one import."""
    names = b"a.dll\0shown\0KERNEL32.dll\0"
    base, place = 0x1000, 0x200  # of the only section, in memory and in the file
    text = base + 0x100
    exports = struct.pack(
        "<IIHHIIIIIII", 0, 0, 0, 0, text, 1, 1, 1, base + 40, base + 44, base + 48
    )
    tables = struct.pack("<IIHH", base, text + 6, 0, 0)
    imports = struct.pack("<IIIII", 0, 0, 0, text + 12, 0) + bytes(20)
    section = (exports + tables + imports).ljust(0x100, b"\0") + names
    directories = struct.pack("<IIII", base, 40, base + 52, 40)
    optional = struct.pack("<H", 0x20B).ljust(112, b"\0") + directories
    header = b"PE\0\0" + struct.pack("<HHIIIHH", 0x8664, 1, 0, 0, 0, len(optional), 0x2000)
    table = struct.pack("<8sIIII16x", b".text", len(section), base, len(section), place)
    start = b"MZ".ljust(0x3C, b"\0") + struct.pack("<I", 0x40)
    data = (start + header + optional + table).ljust(place, b"\0") + section
    library = read_library(data)
    assert library.targets == {"x86_64-windows"}
    assert library.exports == {"shown"}
    assert library.needs == ("KERNEL32.dll",)


def test_a_universal_file_of_macos_has_two_targets():
    data = universal([built("x86_64-darwin"), built("aarch64-darwin")])
    library = read_library(data)
    assert library.targets == {"x86_64-darwin", "aarch64-darwin"}
    assert "shown" in library.exports


def test_an_unsigned_library_for_arm_macs_is_found(tmp_path):
    """The load command of the signature becomes one of another kind."""
    data = built("aarch64-darwin")
    command = struct.pack("<II", 0x1D, 16)
    assert data.count(command) == 1
    unsigned = data.replace(command, struct.pack("<II", 0x26, 16))
    assert read_library(unsigned).unsigned
    sound = models.build_fmu("stage", tmp_path, fmi=3)
    assert "unsigned-for-arm-mac" not in check(sound, run=False).rules
    path = tmp_path / "unsigned.fmu"
    with zipfile.ZipFile(sound) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    pack(path, content | {"binaries/aarch64-darwin/stage.dylib": unsigned})
    assert "unsigned-for-arm-mac" in check(path, run=False).rules


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
