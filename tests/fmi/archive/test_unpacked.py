"""The cache of unpacked archives: whole, mended, tidied; nothing half remains."""

from __future__ import annotations

import os
import time
import zipfile

import pytest

from stickslip import cosim
from stickslip.fmi.archive import unpack, unpacked
from stickslip.fmi.archive import unpacked as members
from tests.corpus.hostile.zips import DEFLATE, Member, zipped

CONTENT = {"a.txt": b"text", "folder/b.bin": bytes(range(256)) * 99}


@pytest.fixture
def room(tmp_path, monkeypatch):
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "room"


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "a.zip"
    packed = [Member(name.encode(), data, DEFLATE) for name, data in CONTENT.items()]
    path.write_bytes(zipped([Member(b"folder/"), *packed]))
    return path


def opened(archive):
    folder = unpack(archive, "room", cosim.FmuError)
    files = (p for p in folder.rglob("*") if p.is_file())
    return folder, {p.relative_to(folder).as_posix(): p.read_bytes() for p in files}


def test_an_archive_written_by_hand_is_one_that_zipfile_reads(archive):
    with zipfile.ZipFile(archive) as file:
        assert file.testzip() is None
        assert {n: file.read(n) for n in file.namelist() if n in CONTENT} == CONTENT


def test_what_is_unpacked_is_what_was_packed(room, archive):
    folder, content = opened(archive)
    assert content == CONTENT
    assert {p.name for p in room.iterdir()} == {folder.name, f"{folder.name}.json"}


@pytest.mark.usefixtures("room")
def test_a_whole_folder_is_not_unpacked_again(archive, monkeypatch):
    opened(archive)
    monkeypatch.setattr(members.zipfile, "ZipFile", None)
    assert opened(archive)[1] == CONTENT


DAMAGES = ["remove", "shorten", "change", "change, with the old times", "add", "add a folder"]
DAMAGES += ["link", "link the folder", "folder", "list", "broken list", "other list"]


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_folder_is_made_anew(room, archive, damage, tmp_path):
    folder, _ = opened(archive)
    listed = folder.with_suffix(".json")
    text, times = folder / "a.txt", (folder / "a.txt").stat()
    if damage.startswith("change"):
        text.write_bytes(b"TEXT")
        if damage != "change":
            os.utime(text, ns=(times.st_atime_ns, times.st_mtime_ns))
    elif damage == "add":
        (folder / "folder" / "c").touch()
    elif damage == "add a folder":
        (folder / "d").mkdir()
        (folder / "d" / "c").touch()
    elif damage == "link":
        (tmp_path / "elsewhere").write_bytes(text.read_bytes())
        text.unlink()
        text.symlink_to(tmp_path / "elsewhere")
    elif damage == "link the folder":
        (folder / "folder").rename(tmp_path / "moved")
        (folder / "folder").symlink_to(tmp_path / "moved")
    elif damage == "other list":
        listed.write_text('{"a.txt": 4, "folder/b.bin": 25344}')
    elif damage == "remove":
        (folder / "a.txt").unlink()
    elif damage == "shorten":
        os.truncate(folder / "folder" / "b.bin", 7)
    elif damage == "folder":
        for file in ("a.txt", "folder/b.bin"):
            (folder / file).unlink()
        (folder / "folder").rmdir()
        folder.rmdir()
    elif damage == "list":
        listed.unlink()
    else:
        listed.write_text('["a')
    again, content = opened(archive)
    assert (again, content) == (folder, CONTENT)
    assert {p.name for p in room.iterdir()} == {folder.name, listed.name}


@pytest.mark.usefixtures("room")
def test_a_copy_of_the_same_content_is_not_unpacked_again(archive, monkeypatch):
    """Other times and inodes, as of a cache that was copied: noted once."""
    folder, _ = opened(archive)
    (folder / "a.txt").unlink()
    (folder / "a.txt").write_bytes(CONTENT["a.txt"])
    monkeypatch.setattr(members.zipfile, "ZipFile", None)
    assert opened(archive)[1] == CONTENT
    monkeypatch.setattr(unpacked, "_check", None)
    assert opened(archive)[1] == CONTENT


def test_ctrl_c_leaves_nothing(room, archive, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(members, "extract_file", interrupted)
        with pytest.raises(KeyboardInterrupt):
            opened(archive)
    assert list(room.iterdir()) == []
    assert opened(archive)[1] == CONTENT


def test_a_full_disk_is_noticed_first(room, archive, monkeypatch):
    usage = members.shutil.disk_usage(archive.parent)._replace(free=10)
    monkeypatch.setattr(members.shutil, "disk_usage", lambda _: usage)
    with pytest.raises(cosim.FmuError, match="only 10 are free"):
        opened(archive)
    assert list(room.iterdir()) == []


def test_what_killed_processes_left_goes_when_it_is_old(room, archive):
    room.mkdir(parents=True)
    for name, age in (("old", 7200), ("new", 60)):
        partial = room / f".unpack-{name}"
        partial.mkdir()
        (partial / "half").touch()
        os.utime(partial, times=(time.time() - age,) * 2)
    opened(archive)
    assert not (room / ".unpack-old").exists()
    assert (room / ".unpack-new" / "half").exists()  # of a process that may still be at it


@pytest.mark.usefixtures("room")
def test_what_nobody_opens_for_months_goes(archive, tmp_path):
    forgotten, _ = opened(archive)
    long_ago = time.time() - 100 * 86400
    os.utime(forgotten.with_suffix(".json"), times=(long_ago, long_ago))
    other = tmp_path / "other.zip"
    other.write_bytes(zipped([Member(b"other")]))
    assert opened(archive)[0] == forgotten  # used after all: it is kept
    opened(other)
    assert forgotten.exists()
    os.utime(forgotten.with_suffix(".json"), times=(long_ago, long_ago))
    third = tmp_path / "third.zip"
    third.write_bytes(zipped([Member(b"third")]))
    opened(third)
    assert not forgotten.exists()
    assert opened(other)[1] == {"other": b""}


def test_a_pipe_is_not_waited_for(room, tmp_path):
    os.mkfifo(tmp_path / "pipe.fmu")
    with pytest.raises(cosim.FmuError, match="is no file"):
        unpack(tmp_path / "pipe.fmu", "room", cosim.FmuError)
    assert not room.exists()
