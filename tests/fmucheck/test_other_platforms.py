"""The binary of this machine is run, whatever is wrong with those of other platforms."""

import sys

import pytest

from stickslip import fmucheck
from stickslip.fmi import toolchain
from tests.corpus.hostile import fmus

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="hostile.c is for POSIX")

HOST = toolchain.host_platform()
BROKEN = {
    "cut": lambda whole: whole[: len(whole) // 2],
    "of this machine": lambda whole: whole,
    "named otherwise": None,
    "text": lambda _: b"this is no library\n",
    "empty": lambda _: b"",
    "header": lambda whole: whole[:64],
}
HERE = {2: HOST.fmi2, 3: HOST.tuple}
FOLDERS = {
    2: ["linux64", "win64", "win32", "darwin64", "linux32", "aarch64-linux"],
    3: ["x86_64-linux", "aarch64-linux", "x86_64-windows", "x86_64-darwin", "aarch64-darwin"],
}


def rules(tmp_path, version, binaries):
    path = tmp_path / "hostile.fmu"
    return fmucheck.check(fmus.write(path, "DoStep fail", version=version, binaries=binaries)).rules


def broken(folder, how):
    suffix = ".dylib" if "darwin" in folder else ".dll" if "win" in folder else ".so"
    name = "hostile" if BROKEN[how] else "otherwise"
    content = (BROKEN[how] or bytes)(fmus.library())
    return {f"binaries/{folder}/{name}{suffix}": content}


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_broken_binaries_elsewhere_do_not_stop_the_run_here(tmp_path, version):
    """A fault that only a run shows is found, with each other platform broken in another way."""
    binaries = {fmus.place(version): fmus.library()}
    alone = rules(tmp_path, version, binaries)
    assert "call-fails" in alone
    others = [folder for folder in FOLDERS[version] if folder not in (HERE[version], HOST.tuple)]
    for folder, how in zip(others, BROKEN, strict=False):
        binaries |= broken(folder, how)
    found = rules(tmp_path, version, binaries)
    assert found - alone >= {"not-a-library"}
    assert alone <= found


@pytest.mark.parametrize("how", [how for how in BROKEN if how != "of this machine"])
@pytest.mark.parametrize("version", [2, 3])
def test_a_broken_binary_here_is_not_run(tmp_path, version, how):
    found = rules(tmp_path, version, broken(HERE[version], how))
    assert "not-run" in found
    assert "call-fails" not in found
