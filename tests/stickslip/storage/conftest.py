"""Folders of results."""

import pytest

from stickslip.storage import staged


def put(folder, name="learn", **files):
    """Write a set of files as one command."""
    with staged(folder, {"name": name}) as staging:
        for file, text in files.items():
            (staging / file).write_text(text)


def texts(folder):
    """Return all files but the manifest."""
    return {
        path.name: path.read_text() for path in folder.iterdir() if path.name != "manifest.json"
    }


@pytest.fixture
def folder(tmp_path):
    """Return a set of two files."""
    put(tmp_path / "out", a="old a", b="old b")
    return tmp_path / "out"
