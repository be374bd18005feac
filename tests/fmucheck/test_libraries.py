"""A library for macOS on arm64 must be signed."""

import struct
import zipfile

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.fmi.binary import read_library
from stickslip.fmucheck import check
from tests.corpus.defects.reference import pack

CODE = """
__attribute__((visibility("default"))) double shown(double x);
double shown(double x) { return x; }
"""


def test_an_unsigned_library_for_arm_macs_is_found(tmp_path):
    """The load command of the signature becomes one of another kind."""
    platform = toolchain.PLATFORMS["aarch64-darwin"]
    data = toolchain.shared_library("a", {"a.c": CODE}, platform=platform).read_bytes()
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
