"""Files of strangers: what is no file, too large or nested without end is refused at once."""

from __future__ import annotations

import os

import pytest

from stickslip.fmi.files import DEEPEST, parse_json, parse_toml, read_limited


def test_a_file_is_read_up_to_its_limit(tmp_path):
    file = tmp_path / "a"
    file.write_bytes(b"12345")
    assert read_limited(file, 5) == b"12345"
    with pytest.raises(OSError, match="5 bytes, at most 4 are read"):
        read_limited(file, 4)


def test_a_sparse_file_is_refused_before_it_is_read(tmp_path):
    with (tmp_path / "a").open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(OSError, match=f"{1 << 40} bytes"):
        read_limited(tmp_path / "a", 1 << 20)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without pipes in folders")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="no regular file"):
        read_limited(tmp_path / "pipe", 10)


@pytest.mark.parametrize("name", [".", "none", "a\0b", "x" * 5000])
def test_what_cannot_be_a_file(tmp_path, name):
    with pytest.raises(OSError, match=r"\S"):
        read_limited(tmp_path / name, 10)


def test_documents_as_they_should_be():
    assert parse_json(b'\xef\xbb\xbf{"a": [1, 2.5, null, "\\u00e4"]}') == {"a": [1, 2.5, None, "ä"]}
    assert parse_toml(b'a.b = [1.5, "x.y.z"] # ....\n') == {"a": {"b": [1.5, "x.y.z"]}}


def test_depth_is_bounded_and_no_less():
    allowed, more = (b"[" * n + b"]" * n for n in (DEEPEST, DEEPEST + 2))
    assert parse_json(allowed)
    assert parse_toml(b"a = " + allowed[1:-1])
    for parse, text in ((parse_json, more), (parse_toml, b"a = " + more)):
        with pytest.raises(ValueError, match="nested too deeply"):
            parse(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"[" * 100_000, "nested too deeply"),
        (b'{"a":' * 100_000, "nested too deeply"),
        (b'{"a": 1, "b": 2, "a": 3}', "'a' is there twice"),
        (b"[NaN]", "NaN is no number"),
        (b"-Infinity", "-Infinity is no number"),
        (b"[1" + b"0" * 400 + b"]", "beyond 1e308"),
        (b"1" * 5000, "digits"),
        (b'{\n"\xff"}', "line 2: byte 0xff is no UTF-8"),
        (b"", "Expecting value"),
    ],
)
def test_json_that_is_refused(text, said):
    with pytest.raises(ValueError, match=said):
        parse_json(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"a = " + b"[" * 100_000, "nested too deeply"),
        (b"a." * 100_000 + b"b = 1", "nested too deeply"),
        (b'",".' * 100_000 + b"b = 1", "nested too deeply"),
        (b"[" + b"a." * 100_000 + b"b]", "nested too deeply"),
        (b"x = {" + b"a." * 100_000 + b"b = 1}", "nested too deeply"),
        (b"a = 1" + b"0" * 400, "beyond 1e308"),
        (b"a = 1\na = 2", "overwrite"),
        (b"a = '\xe4'", "line 1: byte 0xe4 is no UTF-8"),
    ],
)
def test_toml_that_is_refused(text, said):
    with pytest.raises(ValueError, match=said):
        parse_toml(text)
