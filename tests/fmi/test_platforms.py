"""Each platform under the names the standards give it, built from this one."""

from __future__ import annotations

import platform
import sys

import pytest

from stickslip.fmi import toolchain
from stickslip.fmi.toolchain import PLATFORMS, host_platform

# First bytes of a library of each format: ELF, PE, Mach-O of 64 bit.
MAGIC = {".so": b"\x7fELF", ".dll": b"MZ", ".dylib": b"\xcf\xfa\xed\xfe"}
# e_machine of ELF at byte 18
ELF_MACHINE = {"x86_64-linux": 0x3E, "aarch64-linux": 0xB7}


def test_names_are_those_of_the_standards():
    assert {p.tuple: p.fmi2 for p in PLATFORMS.values()} == {
        "x86_64-linux": "linux64",
        "aarch64-linux": "aarch64-linux",
        "x86_64-windows": "win64",
        "x86_64-darwin": "darwin64",
        "aarch64-darwin": "darwin64",
    }
    assert all(key == p.tuple for key, p in PLATFORMS.items())


@pytest.mark.parametrize(
    ("system", "processor", "expected"),
    [
        ("linux", "x86_64", "x86_64-linux"),
        ("linux", "aarch64", "aarch64-linux"),
        ("win32", "AMD64", "x86_64-windows"),
        ("darwin", "arm64", "aarch64-darwin"),
    ],
)
def test_the_host_is_recognised(monkeypatch, system, processor, expected):
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(platform, "machine", lambda: processor)
    assert host_platform() is PLATFORMS[expected]


def test_an_unknown_host_is_named(monkeypatch):
    monkeypatch.setattr(platform, "machine", lambda: "riscv64")
    with pytest.raises(toolchain.ToolchainError, match=r"riscv64-\w+; FMUs run here on x86_64"):
        host_platform()


@pytest.mark.parametrize("name", PLATFORMS)
def test_libraries_are_built_for_other_platforms(name):
    target = PLATFORMS[name]
    export = "dllexport" if target.suffix == ".dll" else 'visibility("default")'
    head = f"__attribute__(({export})) double one(double x)"
    source = {"one.c": f"{head};\n{head} {{ return x + 1.0; }}\n"}
    library = toolchain.shared_library("one", source, platform=target, standalone=True)
    head = library.read_bytes()[:20]
    assert library.suffix == target.suffix
    assert head.startswith(MAGIC[target.suffix])
    if target.tuple in ELF_MACHINE:
        assert head[18] == ELF_MACHINE[target.tuple]
