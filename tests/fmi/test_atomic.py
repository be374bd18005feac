"""What is half-written goes when its process is gone, and odd places are refused."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from stickslip.fmi.files import atomic_write

HALF = """
import sys, time
from pathlib import Path
from stickslip.fmi.files import atomic
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


def test_errors_name_the_file_that_was_to_be_written(tmp_path, monkeypatch):
    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left") as told:
        atomic_write(tmp_path / "a", "x")
    assert told.value.filename == str(tmp_path / "a")
    assert not list(tmp_path.iterdir())
