"""Files appear whole or not at all; what a killed process left goes; odd places are refused."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from stickslip.fmi.files import atomic_write

HALF = """
import sys, time
from pathlib import Path
from stickslip.fmi import files as atomic
with atomic._beside(Path(sys.argv[1])) as (file, _):
    file.write(b"half")
    file.flush()
    print("open", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def writer(tmp_path):
    """A process that has a file half-written."""
    with subprocess.Popen(
        [sys.executable, "-c", HALF, str(tmp_path)], stdout=subprocess.PIPE
    ) as process:
        assert process.stdout.readline() == b"open\n"
        yield process
        process.kill()


def test_what_a_killed_process_left_goes_with_the_next_write(tmp_path, writer):
    (half,) = tmp_path.iterdir()
    atomic_write(tmp_path / "a", "x")
    assert half.read_bytes() == b"half"  # it lives
    writer.kill()
    writer.wait()
    atomic_write(tmp_path / "a", "y")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_a_name_may_be_as_long_as_the_file_system_takes(tmp_path):
    assert atomic_write(tmp_path / ("x" * 255), "y").read_text() == "y"
    with pytest.raises(OSError, match="too long"):
        atomic_write(tmp_path / ("x" * 256), "y")


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX files")
@pytest.mark.parametrize("kind", ["link", "dangling link", "folder", "pipe"])
def test_only_plain_files_are_replaced(tmp_path, kind):
    path, victim = tmp_path / "a", tmp_path / "victim"
    victim.write_text("safe")
    make = {"folder": os.mkdir, "pipe": os.mkfifo}
    make.get(kind, lambda p: p.symlink_to(victim if kind == "link" else "none"))(path)
    with pytest.raises(OSError, match="expected a plain file") as told:
        atomic_write(path, "x")
    assert told.value.filename == str(path)
    assert victim.read_text() == "safe"
    assert {p.name for p in tmp_path.iterdir()} == {"a", "victim"}


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX folders")
def test_file_and_folder_are_on_the_disk_before_it_returns(tmp_path, monkeypatch):
    synced, sync = [], os.fsync

    def note(handle):
        synced.append(os.fstat(handle).st_ino)
        sync(handle)

    monkeypatch.setattr(os, "fsync", note)
    path = atomic_write(tmp_path / "a", "x")
    assert synced == [path.stat().st_ino, tmp_path.stat().st_ino]


def test_bytes_and_text_arrive(tmp_path):
    assert atomic_write(tmp_path / "a" / "b", b"\0\r\n").read_bytes() == b"\0\r\n"
    assert atomic_write(tmp_path / "a" / "b", "π\n").read_bytes() == b"\xcf\x80\n"


@pytest.mark.parametrize("failing", ["fsync", "replace"])
def test_a_failing_write_leaves_the_old_content_and_nothing_else(monkeypatch, tmp_path, failing):
    path = atomic_write(tmp_path / "file", "old")

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, failing, fail)
    with pytest.raises(OSError, match="No space left") as told:
        atomic_write(path, "new")
    assert told.value.filename == str(path)
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
