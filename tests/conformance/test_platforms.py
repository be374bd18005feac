"""FMUs for every platform from this machine."""

import zipfile

import pytest

from stickslip import models
from stickslip.fmi.binary import read_library
from stickslip.fmi.toolchain import PLATFORMS

SYSTEM = {"libc.so.6", "KERNEL32.dll", "/usr/lib/libSystem.B.dylib"}
FOLDERS = {
    2: {"linux64": "so", "aarch64-linux": "so", "win64": "dll", "darwin64": "dylib"},
    3: {name: p.suffix[1:] for name, p in PLATFORMS.items()},
}


@pytest.mark.parametrize("version", [2, pytest.param(3, marks=pytest.mark.thorough)])
def test_one_fmu_holds_all_platforms(version, tmp_path):
    """In FMI 2.0 both processors of macOS share one universal library."""
    fmu = models.build_fmu("stage", tmp_path, fmi=version, platforms=PLATFORMS.values())
    with zipfile.ZipFile(fmu) as archive:
        libraries = {
            name: archive.read(name) for name in archive.namelist() if name.startswith("binaries/")
        }
    expected = {f"binaries/{folder}/stage.{end}" for folder, end in FOLDERS[version].items()}
    assert set(libraries) == expected
    if version == 2:
        assert libraries.pop("binaries/darwin64/stage.dylib")[:4] == b"\xca\xfe\xba\xbe"
    for library in libraries.values():
        found = read_library(library)
        assert set(found.needs) <= SYSTEM
        assert f"fmi{version}DoStep" in found.exports


@pytest.mark.platforms
def test_an_empty_cache_gives_the_same_bytes_for_every_platform(tmp_path, monkeypatch):
    here = {}
    for folder in ("one", "two with a blank"):
        monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / folder / "cache"))
        fmu = models.build_fmu("stage", tmp_path / folder, platforms=PLATFORMS.values())
        here[folder] = fmu.read_bytes()
    assert len(set(here.values())) == 1
