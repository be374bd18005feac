"""Archives of any structure, and the cache of unpacked ones: whole, mended, tidied."""

import io
import os
import shutil
import struct
import time
import zipfile
import zlib
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip import cosim
from stickslip.fmi.archive import unpack, unpacked
from stickslip.fmi.archive.directory import Refused, check_members
from stickslip.fmi.archive.unpacked import extract
from tests.corpus.hostile.zips import DEFLATE, STORED, Member, zipped

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


def test_what_is_unpacked_is_what_was_packed(room, archive):
    folder, content = opened(archive)
    assert content == CONTENT
    assert {p.name for p in room.iterdir()} == {folder.name, f"{folder.name}.json"}


def change_with_old_times(folder, _):
    text, times = folder / "a.txt", (folder / "a.txt").stat()
    text.write_bytes(b"TEXT")
    os.utime(text, ns=(times.st_atime_ns, times.st_mtime_ns))


def add_a_folder(folder, _):
    (folder / "d").mkdir()
    (folder / "d" / "c").touch()


def link(folder, elsewhere):
    (folder / "a.txt").rename(elsewhere)
    (folder / "a.txt").symlink_to(elsewhere)


def link_the_folder(folder, elsewhere):
    (folder / "folder").rename(elsewhere)
    (folder / "folder").symlink_to(elsewhere)


DAMAGES = {
    "remove": lambda folder, _: (folder / "a.txt").unlink(),
    "shorten": lambda folder, _: os.truncate(folder / "folder" / "b.bin", 7),
    "change": lambda folder, _: (folder / "a.txt").write_bytes(b"TEXT"),
    "add": lambda folder, _: (folder / "folder" / "c").touch(),
    "folder": lambda folder, _: shutil.rmtree(folder),
    "list": lambda folder, _: folder.with_suffix(".json").unlink(),
    "broken list": lambda folder, _: folder.with_suffix(".json").write_text('["a'),
    "other list": lambda folder, _: folder.with_suffix(".json").write_text('{"a.txt": 4}'),
    **{f.__name__: f for f in (change_with_old_times, add_a_folder, link, link_the_folder)},
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_folder_is_made_anew(room, archive, damage, tmp_path):
    folder, _ = opened(archive)
    listed = folder.with_suffix(".json")
    DAMAGES[damage](folder, tmp_path / "elsewhere")
    again, content = opened(archive)
    assert (again, content) == (folder, CONTENT)
    assert {p.name for p in room.iterdir()} == {folder.name, listed.name}


@pytest.mark.usefixtures("room")
def test_a_copy_of_the_same_content_is_not_unpacked_again(archive, monkeypatch):
    """Other times and inodes, as of a cache that was copied: noted once."""
    folder, _ = opened(archive)
    (folder / "a.txt").unlink()
    (folder / "a.txt").write_bytes(CONTENT["a.txt"])
    monkeypatch.setattr(unpacked.zipfile, "ZipFile", None)
    assert opened(archive)[1] == CONTENT
    monkeypatch.setattr(unpacked, "_check", None)
    assert opened(archive)[1] == CONTENT


def test_a_full_disk_is_noticed_first(room, archive, monkeypatch):
    usage = unpacked.shutil.disk_usage(archive.parent)._replace(free=10)
    monkeypatch.setattr(unpacked.shutil, "disk_usage", lambda _: usage)
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
    unpacked._tidy.cache_clear()  # as in another process
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
    unpacked._tidy.cache_clear()  # as in another process
    opened(other)
    assert forgotten.exists()
    os.utime(forgotten.with_suffix(".json"), times=(long_ago, long_ago))
    third = tmp_path / "third.zip"
    third.write_bytes(zipped([Member(b"third")]))
    unpacked._tidy.cache_clear()
    opened(third)
    assert not forgotten.exists()
    assert opened(other)[1] == {"other": b""}


LETTERS = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), max_size=9)
PARTS = st.one_of(LETTERS, st.sampled_from(["..", ".", "", "con", "C:", "a.", "\\", "a\0", "\n"]))
PATHS = st.lists(PARTS, min_size=1, max_size=5).map("/".join)
BROKEN = st.fixed_dictionaries(
    {},
    optional={
        "flags": st.integers(0, 2**16 - 1),
        "method": st.integers(0, 2**16 - 1),
        "mode": st.integers(0, 2**16 - 1),
        "needs": st.integers(0, 2**16 - 1),
        "crc": st.integers(0, 2**32 - 1),
        "size": st.integers(0, 2**32 - 1),
        "packed_size": st.integers(0, 2**32 - 1),
        "offset": st.integers(0, 2**32 - 1),
        "extra": st.binary(max_size=30),
        "content": st.binary(max_size=30),
    },
)


@st.composite
def archives(draw):
    """Return members, some of them broken, as bytes."""
    members = [
        Member(
            name.encode(), draw(st.binary(max_size=99)), draw(st.sampled_from([STORED, DEFLATE]))
        )
        if draw(st.booleans())
        else Member(name.encode(), draw(st.binary(max_size=99)), **draw(BROKEN))
        for name in draw(st.lists(PATHS, max_size=4))
    ]
    return zipped(members, before=draw(st.binary(max_size=2)), comment=draw(st.binary(max_size=9)))


@settings(max_examples=40)
@given(archives())
def test_whatever_is_unpacked_lies_in_its_folder(tmp_path_factory, data):
    top = tmp_path_factory.mktemp("room")
    try:
        checks = extract(io.BytesIO(data), top / "new")
    except Refused as fault:
        assert str(fault).isprintable()  # noqa: PT017 - it need not be raised
        return
    found = {p for p in top.rglob("*") if not p.is_dir()}
    assert found == {top / "new" / name for name in checks}
    assert not any(p.is_symlink() for p in found)
    assert all(zlib.crc32(p.read_bytes()) == checks[str(p.relative_to(top / "new"))] for p in found)


def lawful(**more):
    return zipped([Member(b"a", b"text", DEFLATE), Member(b"d/"), Member(b"d/b", b"")], **more)


def zip64():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as file, file.open("a", "w", force_zip64=True) as member:
        member.write(b"text")
    return stream.getvalue()


def streamed():
    """Return an archive with its sizes behind the data, as tools write that cannot seek."""

    class Pipe(io.BytesIO):
        def seekable(self):
            return False

        def seek(self, *_):
            raise io.UnsupportedOperation

    stream = Pipe()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("a", b"text")
    return stream.getvalue()


def zip64_end(at=0):
    """Return an archive whose end says nothing but where the end of a zip64 is."""
    plain = lawful()
    size, offset = struct.unpack("<2L", plain[-10:-2])
    end = struct.pack("<4sQ2H2L4Q", b"PK\x06\x06", 44, 45, 45, 0, 0, 3, 3, size, offset)
    end += struct.pack("<4sLQL", b"PK\x06\x07", 0, len(plain) - 22 + at, 1)
    return plain[:-22] + end + b"PK\x05\x06\0\0\0\0" + b"\xff" * 12 + b"\0\0"


@pytest.mark.parametrize(("at", "message"), [(99, "points behind itself"), (-1, "end is missing")])
def test_a_zip64_whose_end_is_elsewhere_is_damaged(tmp_path, at, message):
    with pytest.raises(Refused, match=message):
        extract(io.BytesIO(zip64_end(at)), tmp_path / "new")


@pytest.mark.parametrize(
    "data",
    [lawful(), lawful(comment=b"c" * 0xFFFF), zip64(), zip64_end(), streamed()],
    ids=["plain", "a huge comment", "zip64", "zip64 at its end", "streamed"],
)
def test_lawful_but_odd_archives_are_taken(tmp_path, data):
    checks = extract(io.BytesIO(data), tmp_path / "new")
    assert checks["a"] == zlib.crc32(b"text")
    assert (tmp_path / "new" / "a").read_bytes() == b"text"


def test_a_file_that_occurs_again_with_the_same_content_is_unpacked_once(tmp_path):
    data = zipped(
        [Member(b"b/"), *[Member(b"a", b"text")] * 2, Member(b"b/"), Member(b"b/c", b"d")]
    )
    checks = extract(io.BytesIO(data), tmp_path / "new")
    assert list(checks) == ["a", "b/c"]
    assert (tmp_path / "new" / "a").read_bytes() == b"text"


@pytest.mark.parametrize("name", ["a.", "a ", "b./a"])
@pytest.mark.parametrize("system", ["posix", "nt"])
def test_a_name_that_windows_shortens_is_refused_there_only(tmp_path, monkeypatch, name, system):
    data = io.BytesIO(zipped([Member(name.encode(), b"text")]))
    monkeypatch.setattr("stickslip.fmi.archive.directory.os", SimpleNamespace(name=system))
    if system == "nt":
        with pytest.raises(Refused, match="dot or blank at its end"):
            extract(data, tmp_path / "new")
        return
    extract(data, tmp_path / "new")
    assert (tmp_path / "new" / name).read_bytes() == b"text"


@pytest.mark.parametrize("n", [1, 100])
@pytest.mark.parametrize("ratio", [499, 501])
def test_more_than_500_times_its_size_is_a_zip_bomb(n, ratio):
    """In one member that is large when unpacked, or in many small ones together."""
    packed = 2**20 // n
    members = []
    for i in range(n):
        members.append(zipfile.ZipInfo(f"{i}.bin"))
        members[i].compress_type, members[i].header_offset = zipfile.ZIP_DEFLATED, 2 * i * packed
        members[i].compress_size, members[i].file_size = packed, ratio * packed
        members[i].CRC = 0
    if ratio < 500:
        assert len(check_members(members, n)) == n
        return
    with pytest.raises(Refused, match="zip bomb"):
        check_members(members, n)
