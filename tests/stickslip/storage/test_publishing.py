"""One process at a time replaces its own set, and nothing but that."""

import json
import os
import shutil
import threading

import pytest

from stickslip.errors import ResultsError, UsageError
from stickslip.fmi.files import atomic_write
from stickslip.storage import locked, staged, verify
from tests.stickslip.storage.conftest import put, texts


def test_what_a_command_wrote_before_goes_and_what_others_wrote_stays(folder):
    put(folder, "validate", table="t")
    put(folder, a="new a", c="new c")
    assert texts(folder) == {"a": "new a", "c": "new c", "table": "t"}
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["command"] == {"name": "learn"}
    assert manifest["earlier"] == [{"command": {"name": "validate"}, "files": ["table"]}]
    assert not verify(folder).faults
    put(folder, "validate", a="their a")
    assert texts(folder) == {"a": "their a", "c": "new c"}
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["earlier"] == [{"command": {"name": "learn"}, "files": ["c"]}]
    assert not verify(folder).faults


def test_what_someone_changed_or_added_is_not_deleted(folder):
    (folder / "b").write_text("mine")
    (folder / "notes").write_text("mine too")
    put(folder, a="new a")
    assert texts(folder) == {"a": "new a", "b": "mine", "notes": "mine too"}
    assert verify(folder).faults == {"b": "additional", "notes": "additional"}


def test_a_command_can_tell_which_files_must_not_stay(folder):
    put(folder, "validate", table="t")
    with staged(folder, {"name": "learn"}, without=["absent", "table", "a"]) as staging:
        (staging / "a").write_text("new a")
    assert texts(folder) == {"a": "new a"}
    assert not verify(folder).faults


def test_an_error_leaves_the_old_set_alone_and_names_the_file_as_it_will_be_called(folder):
    def write():
        with staged(folder, {}) as staging:
            (staging / "a").write_text("half")
            raise OSError(28, "No space left on device", str(staging / "a"))

    with pytest.raises(OSError, match="No space") as told:
        write()
    assert told.value.filename == str(folder / "a")
    assert texts(folder) == {"a": "old a", "b": "old b"}


def test_another_thread_is_another_writer_and_a_nested_block_is_not(folder):
    refused = []

    def write():
        try:
            put(folder, a="of the thread")
        except UsageError as error:
            refused.append(str(error))

    with locked(folder):
        thread = threading.Thread(target=write)
        thread.start()
        thread.join()
        put(folder, a="nested")
    assert f"process {os.getpid()} is writing there" in refused[0]
    assert texts(folder) == {"a": "nested"}


def test_a_folder_removed_while_it_is_claimed_is_made_anew(folder):
    with locked(folder):
        shutil.rmtree(folder)
        put(folder, a="new a")
    assert texts(folder) == {"a": "new a"}


def test_a_folder_removed_while_it_is_written_gets_no_half_set(folder):

    def write():
        with staged(folder, {"name": "learn"}) as staging:
            (staging / "a").write_text("before")
            shutil.rmtree(folder)
            atomic_write(staging / "b", "after")

    with pytest.raises(ResultsError, match="was removed while results were written"):
        write()
    assert not folder.exists() or texts(folder) == {}


@pytest.mark.parametrize("kind", ["folder", "link", "pipe"])
def test_what_is_in_the_way_is_named_before_anything_changes(folder, kind):
    way = folder / "c"
    {"folder": os.mkdir, "link": lambda p: p.symlink_to("a"), "pipe": os.mkfifo}[kind](way)
    with pytest.raises(OSError, match="expected a plain file") as told:
        put(folder, a="new a", c="new c")
    assert told.value.filename == str(way)
    assert (folder / "a").read_text() == "old a"
    assert not list(folder.glob(".stickslip-*"))


def test_what_strangers_left_ready_moves_and_deletes_nothing_outside(folder, tmp_path):
    (tmp_path / "victim").write_text("safe")
    ready = folder / ".stickslip-ready"
    ready.mkdir()
    (ready / "link").symlink_to(tmp_path)
    (ready / "manifest.json").write_text('{"sha256": {}}')
    evil = {"sha256": {"../victim": "0" * 64, "link/victim": "0" * 64}}
    (folder / "manifest.json").write_text(json.dumps(evil))
    with pytest.raises(UsageError, match="not a manifest of results"):
        verify(folder)
    (folder / "manifest.json").unlink()
    assert verify(folder).faults == {"a": "additional", "b": "additional", "link": "additional"}
    assert (tmp_path / "victim").read_text() == "safe"
