"""Folders of results, and a process that has one."""

import pytest

from stickslip.storage import staged


@pytest.fixture
def folder(tmp_path):
    """A set of two files."""
    _write(tmp_path / "out", a="old a", b="old b")
    return tmp_path / "out"


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
