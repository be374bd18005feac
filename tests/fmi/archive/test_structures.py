"""Archives of random structure: taken when lawful, refused in words, never out of their folder."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.fmi.archive.directory import Refused, check_members, place
from stickslip.fmi.archive.unpacked import extract
from tests.corpus.hostile.zips import DEFLATE, STORED, Member, zipped

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


@settings(max_examples=80)
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


@settings(max_examples=50)
@given(
    st.dictionaries(
        LETTERS.filter(lambda n: n and "/" not in n), st.binary(max_size=99), max_size=5
    )
)
def test_what_zipfile_packs_is_taken_unless_a_name_is_in_doubt(tmp_path_factory, content):
    top, stream = tmp_path_factory.mktemp("room"), io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in content.items():
            file.writestr(name, data)
        members = file.infolist()
    try:
        check_members(members, len(content))
    except Refused:
        return
    extract(stream, top / "new")
    assert {p.name: p.read_bytes() for p in (top / "new").iterdir()} == content


@given(PATHS)
def test_a_name_that_is_taken_leads_below(name):
    try:
        path = place(name)
    except Refused:
        return
    assert (Path("/room") / path).resolve().is_relative_to("/room")
    assert "\\" not in name


@pytest.mark.parametrize(
    "name",
    [
        "modelDescription.xml",
        "./a",
        "a/b/c.so",
        "resources/",
        "\u00e4\u4e2d.txt",
        "console.c",
        "aux-1",
    ],
)
def test_usual_names_are_taken(name):
    assert place(name)


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
