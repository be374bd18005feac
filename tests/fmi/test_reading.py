"""Untrusted files, values by name, and files that appear whole or not at all."""

import os
import stat
import subprocess
import sys
from collections import namedtuple
from types import MappingProxyType

import pandas as pd
import pytest

from stickslip.fmi.by_name import by_name
from stickslip.fmi.errors import Fault
from stickslip.fmi.files import DEEPEST, atomic_write, parse_json, parse_toml, read_limited


def test_a_file_is_read_up_to_its_limit(tmp_path):
    file = tmp_path / "a"
    file.write_bytes(b"12345")
    assert read_limited(file, 5) == b"12345"
    with pytest.raises(OSError, match="5 bytes, at most 4 are read"):
        read_limited(file, 4)


@pytest.mark.parametrize("name", [".", "none", "a\0b", "x" * 5000])
def test_what_cannot_be_a_file(tmp_path, name):
    with pytest.raises(OSError, match=r"\S"):
        read_limited(tmp_path / name, 10)


def test_depth_is_bounded_and_no_less():
    allowed, more = (b"[" * n + b"]" * n for n in (DEEPEST, DEEPEST + 2))
    assert parse_json(allowed)
    assert parse_toml(b"a = " + allowed[1:-1])
    for parse, text in ((parse_json, more), (parse_toml, b"a = " + more)):
        with pytest.raises(ValueError, match="nested too deeply"):
            parse(text)


JSON = [
    (b"[" * 100_000, "nested too deeply"),
    (b'{"a":' * 100_000, "nested too deeply"),
    (b'{"a": 1, "b": 2, "a": 3}', "'a' is there twice"),
    (b"[NaN]", "NaN is no number"),
    (b"-Infinity", "-Infinity is no number"),
    (b"[1" + b"0" * 400 + b"]", "beyond 1e308"),
    (b"1" * 5000, "digits"),
    (b'{\n"\xff"}', "line 2: byte 0xff is no UTF-8"),
    (b"", "Expecting value"),
]
TOML = [
    (b"a = " + b"[" * 100_000, "nested too deeply"),
    (b"a." * 100_000 + b"b = 1", "nested too deeply"),
    (b'",".' * 100_000 + b"b = 1", "nested too deeply"),
    (b"[" + b"a." * 100_000 + b"b]", "nested too deeply"),
    (b"x = {" + b"a." * 100_000 + b"b = 1}", "nested too deeply"),
    (b"a = 1" + b"0" * 400, "beyond 1e308"),
    (b"a = 1\na = 2", "overwrite"),
    (b"a = '\xe4'", "line 1: byte 0xe4 is no UTF-8"),
]


@pytest.mark.parametrize(
    ("parse", "text", "said"),
    [(parse, *row) for parse, rows in ((parse_json, JSON), (parse_toml, TOML)) for row in rows],
)
def test_json_and_toml_that_are_refused(parse, text, said):
    with pytest.raises(ValueError, match=said):
        parse(text)


TABLE = pd.DataFrame({"F_c": [1.0, 2.0], "n": [3, 4]})
DOTTED = pd.DataFrame({"stage.m": [1.0]})
Pair = namedtuple("Pair", "F_c n")


@pytest.mark.parametrize(
    "given",
    [
        {"F_c": 2.0, "n": 4}, MappingProxyType({"F_c": 2.0, "n": 4}), TABLE.iloc[1], TABLE.loc[[1]],
        list(TABLE.itertuples())[1], list(TABLE.itertuples(index=False))[1], Pair(2.0, 4),
    ],
)  # fmt: skip
def test_a_row_is_a_dictionary(given):
    assert by_name("parameters", given, Fault) == {"F_c": 2.0, "n": 4}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (TABLE, r"one row, got one of 2; see table\.iloc\[0\]"),
        (next(DOTTED.itertuples()), r"itertuples called a column _1, .*table\.iloc\[0\]"),
        (TABLE["F_c"], r"expected each by its name, as \{'name': \.\.\.\}, got 0"),
        ({1: 2.0}, r"expected each by its name, .*got 1$"),
        ([("F_c", 1.0)], r"expected a dictionary with a name for each, got \[\('F_c', 1\.0\)\]"),
        ("F_c=1", "expected a dictionary with a name for each, got 'F_c=1'"),
        (pd.Series([1.0, 2.0], ["m", "m"]), "a name comes twice: m, m"),
    ],
)
def test_what_has_no_names_ends_in_one_line(given, message):
    with pytest.raises(Fault, match=f"^parameters: .*{message}") as told:
        by_name("parameters", given, Fault)
    assert "\n" not in str(told.value)


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


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX permissions")
def test_permissions_follow_the_umask(tmp_path):
    before = os.umask(0o027)
    try:
        path = atomic_write(tmp_path / "file", "x")
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
