"""The binary of this machine is run, whatever is wrong with those of other platforms."""

import functools
import sys

import pytest

from stickslip import fmucheck
from stickslip.fmi import toolchain
from tests.corpus.hostile import fmus

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="hostile.c is for POSIX")

HOST = toolchain.host_platform()
BROKEN = {
    "text": lambda _: b"this is no library\n",
    "empty": lambda _: b"",
    "zeros": lambda whole: bytes(len(whole)),
    "cut": lambda whole: whole[: len(whole) // 2],
    "header": lambda whole: whole[:64],
    "of this machine": lambda whole: whole,
    "named otherwise": None,
}
FOLDERS = {
    2: ["linux64", "win64", "win32", "darwin64", "linux32", "aarch64-linux"],
    3: ["x86_64-linux", "aarch64-linux", "x86_64-windows", "x86_64-darwin", "aarch64-darwin"],
}
HERE = {2: {HOST.fmi2, HOST.tuple}, 3: {HOST.tuple}}


def rules(tmp_path, version, behaviour, binaries):
    path = tmp_path / "hostile.fmu"
    report = fmucheck.check(fmus.write(path, behaviour, version=version, binaries=binaries))
    return {(f.rule, f.place) for f in report}


@pytest.fixture(scope="module")
def of_this_machine(tmp_path_factory):
    """Return what is found where there is no other binary."""

    @functools.cache
    def found(version):
        own = {fmus.place(version): fmus.library()}
        return rules(tmp_path_factory.mktemp("own"), version, "DoStep fail", own)

    return found


def broken(folder, how):
    suffix = ".dll" if "win" in folder and "dar" not in folder else ".so"
    suffix = ".dylib" if "darwin" in folder else suffix
    if BROKEN[how] is None:
        return {f"binaries/{folder}/otherwise{suffix}": fmus.library()}
    return {f"binaries/{folder}/hostile{suffix}": BROKEN[how](fmus.library())}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("version", "how"), [(2, "cut"), (3, "of this machine"), (2, "named otherwise")]
)
def test_a_broken_binary_elsewhere_does_not_stop_the_run_here(
    tmp_path, of_this_machine, version, how
):
    """A fault that only a run shows is found, with one other platform or all of them broken."""
    own = {fmus.place(version): fmus.library()}
    others = [folder for folder in FOLDERS[version] if folder not in HERE[version]]
    alone = of_this_machine(version)
    assert "call-fails" in {rule for rule, _ in alone}
    for folders in (others[:1], others):
        binaries = own | {k: v for folder in folders for k, v in broken(folder, how).items()}
        found = rules(tmp_path, version, "DoStep fail", binaries)
        assert alone <= found
        assert {rule for rule, _ in found - alone} & {
            "not-a-library",
            "wrong-architecture",
            "binary-missing",
        }


@pytest.mark.parametrize("how", [how for how in BROKEN if how != "of this machine"])
@pytest.mark.parametrize("version", [2, 3])
def test_a_broken_binary_here_is_not_run(tmp_path, version, how):
    folder = HOST.fmi2 if version == 2 else HOST.tuple
    found = {rule for rule, _ in rules(tmp_path, version, "DoStep fail", broken(folder, how))}
    assert "not-run" in found
    assert "call-fails" not in found
