"""Files appear whole or not at all, in the folder the user chose."""

from __future__ import annotations

import os
import stat
import sys
import threading
from pathlib import Path

import pytest

from stickslip.fmi.files import atomic_write
from stickslip.fmi.toolchain import cache_directory


def test_the_cache_lies_where_the_environment_says(monkeypatch, tmp_path):
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "here"))
    assert cache_directory() == tmp_path / "here"


@pytest.mark.parametrize(
    ("system", "variable", "place"),
    [
        ("linux", "XDG_CACHE_HOME", "base/stickslip"),
        ("win32", "LOCALAPPDATA", "base/stickslip"),
        ("darwin", "HOME", "base/Library/Caches/stickslip"),
        ("linux", "HOME", "base/.cache/stickslip"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="pretends other systems from a POSIX one")
def test_without_it_the_cache_is_the_users(monkeypatch, tmp_path, system, variable, place):
    monkeypatch.delenv("STICKSLIP_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setenv(variable, str(tmp_path / "base"))
    assert cache_directory() == tmp_path / place


def test_bytes_and_text_arrive(tmp_path):
    assert atomic_write(tmp_path / "a" / "b", b"\0\r\n").read_bytes() == b"\0\r\n"
    assert atomic_write(tmp_path / "a" / "b", "π\n").read_bytes() == b"\xcf\x80\n"


@pytest.mark.parametrize("failing", ["fsync", "replace"])
def test_a_failing_write_leaves_the_old_content_and_nothing_else(monkeypatch, tmp_path, failing):
    path = atomic_write(tmp_path / "file", "old")

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, failing, fail)
    with pytest.raises(OSError, match="No space left"):
        atomic_write(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_reader_never_sees_a_part(tmp_path):
    """While one thread writes, every read finds one of the two contents, whole."""
    contents = [bytes([n]) * 200_000 for n in (1, 2)]
    path = atomic_write(tmp_path / "file", contents[0])
    seen = set()
    stop = threading.Event()

    def read() -> None:
        while not stop.is_set():
            seen.add(path.read_bytes())

    reader = threading.Thread(target=read)
    reader.start()
    for n in range(40):
        atomic_write(path, contents[n % 2])
    stop.set()
    reader.join()
    assert seen <= set(contents)
    assert seen


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX permissions")
def test_permissions_follow_the_umask(tmp_path):
    before = os.umask(0o027)
    try:
        path = atomic_write(tmp_path / "file", "x")
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_folder_that_cannot_be_made_is_an_os_error(tmp_path):
    obstacle = tmp_path / "file"
    obstacle.write_text("x")
    with pytest.raises(OSError, match="file"):
        atomic_write(Path(obstacle, "below"), "y")
