"""Folders of results, and a process that has one."""

import subprocess
import sys

import pytest

from stickslip.storage import staged

HOLDER = """
import sys, time
from pathlib import Path
from stickslip.storage import staged
with staged(Path(sys.argv[1]), {"name": "other"}) as staging:
    (staging / "half").write_text("written")
    print("has it", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def folder(tmp_path):
    """A set of two files."""
    _write(tmp_path / "out", a="old a", b="old b")
    return tmp_path / "out"


@pytest.fixture
def holder(folder):
    """A process in the middle of writing into the folder."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(folder)], stdout=subprocess.PIPE
    ) as process:
        assert process.stdout.readline() == b"has it\n"
        yield process
        process.kill()


def _write(folder, name="learn", **files):
    with staged(folder, {"name": name}) as staging:
        for file, text in files.items():
            (staging / file).write_text(text)


@pytest.fixture
def put():
    """Return what writes a set of files as one command."""
    return _write


def _texts(folder):
    return {
        path.name: path.read_text() for path in folder.iterdir() if path.name != "manifest.json"
    }


@pytest.fixture
def texts():
    """Return what reads all files but the manifest."""
    return _texts
