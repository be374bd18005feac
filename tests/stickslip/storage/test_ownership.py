"""Nothing is replaced or deleted that a manifest of ours does not list unchanged."""

import pytest

from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.papers.lugre import folder as reproduction_results
from stickslip.papers.lugre import record
from stickslip.storage import reserved, staged, verify
from stickslip.storage.publishing import READY
from stickslip.studies.learn import folder as learned_folder
from tests.stickslip.storage.conftest import put

pytestmark = pytest.mark.slow

FOREIGN = {
    "unlisted": lambda folder: (folder / "c").write_text("mine"),
    "changed": lambda folder: (folder / "a").write_text("mine"),
    "without a manifest": lambda folder: (folder / "manifest.json").unlink(),
    "a manifest of something else": lambda folder: (folder / "manifest.json").write_text("{}"),
}


def everything(folder):
    paths = (path for path in folder.rglob("*") if path.name != ".stickslip-lock")
    return {path: path.read_bytes() for path in paths if path.is_file()}


@pytest.mark.parametrize("how", FOREIGN)
@pytest.mark.parametrize("when", ["before", "meanwhile"])
def test_a_file_of_the_user_is_named_and_stays(folder, how, when):
    def appear(at):
        if at == when:
            FOREIGN[how](folder)
            left.update(everything(folder))

    def write():
        with reserved(folder, ["a", "c"]):
            began.append(when)
            appear("meanwhile")
            with staged(folder, {"name": "learn"}) as staging:
                for name in ("a", "c"):
                    (staging / name).write_text("new")

    left, began = {}, []
    appear("before")
    named = {"unlisted": "c", "a manifest of something else": "manifest.json"}.get(how, "a")
    with pytest.raises(UsageError, match=rf"{folder / named}: .*: move it away, or choose"):
        write()
    assert began == ([] if when == "before" else [when])  # nothing is computed first
    assert everything(folder) == left


def test_a_file_to_be_removed_is_the_users_too(folder):
    (folder / "stale").write_text("mine")
    with (
        pytest.raises(UsageError, match="stale: exists, and no manifest"),
        staged(folder, {"name": "learn"}, without=["stale"]) as staging,
    ):
        (staging / "a").write_text("new a")
    assert (folder / "stale").read_text() == "mine"
    assert (folder / "a").read_text() == "old a"


def test_a_file_that_came_after_a_killed_process_is_named_by_verify(folder, tmp_path):
    put(tmp_path / "other", a="new a", c="new c")
    (tmp_path / "other").rename(folder / READY)
    (folder / "c").write_text("mine")
    with pytest.raises(UsageError, match="c: exists, and no manifest"):
        verify(folder)
    assert (folder / "c").read_text() == "mine"
    (folder / "c").unlink()
    found = verify(folder)
    assert (found.intact, found.faults) == (2, {})
    assert (folder / "c").read_text() == "new c"
    assert not (folder / "b").exists()


def test_absent_files_and_those_of_other_commands_are_no_obstacle(folder):
    """Such as FMUs that a repository leaves out."""
    put(folder, "reproduce", a="another a", c="c")
    (folder / "b").unlink()
    with reserved(folder, ["a", "b", "c", "d"]):
        put(folder, a="new a", b="new b", d="new d")
    assert not verify(folder).faults


def test_what_is_replaced_is_told_by_every_command(folder, caplog):
    for names, told in ((["d"], False), (["a", "d"], True)):
        caplog.clear()
        with reserved(folder, names):
            assert ("results of an earlier run" in caplog.text) == told


FLEET = (
    "fleet.csv", "fleet.json", "fleet.svg", "drives/b/learned.json", "unfinished/b/learned.json",
)  # fmt: skip
COMMANDS = {
    "learn": (
        ["learn", "--log", __file__],
        learned_folder.FILES,
        "studies.learn.log_learning.learn",
    ),
    "reproduce": (["reproduce"], reproduction_results.FILES, "papers.lugre.reproduction.reproduce"),
    "record": (
        ["reproduce", "--mode", "record"],
        record.RECORD_FILES,
        "papers.lugre.record.reproduce_from_recording",
    ),
    "identify": (["identify"], ["identified.json"], "identification.stages.identify"),
    "fleet": (["fleet", "TABLE"], FLEET, "work.kept_jobs.run_jobs"),
    "resumed fleet": (["fleet", "TABLE", "--resume"], FLEET, "work.kept_jobs.run_jobs"),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_compute_nothing_before_they_name_it(command, tmp_path, capsys, monkeypatch):
    """Drive b has no log, so its learned.json would be removed, not written."""
    (tmp_path / "table.csv").write_text("name,log\na,none.csv\nb,none.csv\n")
    arguments, files, compute = COMMANDS[command]
    words = [str(tmp_path / "table.csv") if word == "TABLE" else word for word in arguments]
    monkeypatch.setattr(f"stickslip.{compute}", None)
    for k, name in enumerate(files):
        out = tmp_path / str(k)
        path = out / name
        path.parent.mkdir(parents=True)
        path.write_text("mine")
        assert main([*words, "--out", str(out)]) == 1
        said = capsys.readouterr().err
        assert said.startswith(f"stickslip: {path}: exists, and no manifest.json lists it")
        assert said.count("\n") == 1
        assert [one for one in out.rglob("*") if one.is_file()] == [path]
