"""A fleet loses nothing: not to workers that die, not to Ctrl-C, not to a drive that fails."""

import os
import shutil
from functools import partial

import pandas as pd
import pytest
from fleet_jobs import Counting, Deadly, brief, quick

from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.studies.fleet.study import learn_fleet
from stickslip.studies.fleet.table import read_fleet
from stickslip.studies.fleet.writing import fleet_table, write_fleet
from stickslip.work.jobs import DIED, Execution

pytestmark = pytest.mark.slow


def written(folder, *arguments, **options):
    fleet = learn_fleet(*arguments, folder, **options)
    write_fleet(fleet, fleet_table(fleet), folder)
    return fleet


@pytest.mark.thorough
def test_a_drive_that_kills_its_worker_fails_and_no_other(drives, tmp_path):
    job, execution = Deadly(os.getpid()), Execution(2, "processes")
    fleet = learn_fleet(drives("a", "kills", "b"), tmp_path / "out", execution=execution, job=job)
    assert fleet.reasons == {"kills": DIED}
    alone = learn_fleet(drives("a", "b"), tmp_path / "alone", job=quick)
    assert fleet.learned == alone.learned


@pytest.mark.parametrize("where", ["serial", "threads"])
def test_interrupted_and_resumed_is_the_same_as_never_interrupted(where, drives, tmp_path):
    fleet = drives("a", "b", "c", "d")
    out, diary = tmp_path / "out", tmp_path / "diary"
    execution = Execution(1 if where == "serial" else 2)
    with pytest.raises(KeyboardInterrupt, match=r"interrupted; . of 4 drives.*resume=True"):
        learn_fleet(fleet, out, execution=execution, job=Counting(diary, "c"))
    kept = sorted(path.parent.name for path in out.rglob("learned.json"))
    assert kept
    with pytest.raises(UsageError, match="study did not end; continue with resume=True"):
        learn_fleet(fleet, out, job=quick)
    diary.unlink()
    resumed = Execution(execution.workers, resume=True)
    assert written(out, fleet, execution=resumed, job=Counting(diary)).kept == len(kept)
    assert sorted(diary.read_text().split() + kept) == ["a", "b", "c", "d"]
    written(tmp_path / "whole", fleet, job=quick)
    assert files(out) == files(tmp_path / "whole")


def test_what_changed_is_learned_again(drives, tmp_path, monkeypatch):
    out, diary, log = tmp_path / "out", tmp_path / "diary", tmp_path / "none.csv"
    resume = Execution(resume=True)

    def learned_again(*names, seed=0):
        diary.write_text("")
        written(out, drives(*names), seed=seed, execution=resume, job=Counting(diary))
        return diary.read_text().split()

    assert learned_again("a", "b") == ["a", "b"]
    assert learned_again("a", "b", "c") == ["c"]
    log.write_text("another log")
    assert learned_again("c", "a") == ["c", "a"]
    assert learned_again("c", "a") == []
    assert learned_again("a", seed=1) == ["a"]
    monkeypatch.setattr("stickslip.studies.fleet.study.versions", lambda: {"stickslip": "another"})
    assert learned_again("a", seed=1) == ["a"]


def test_a_result_that_is_missing_is_learned_again_and_a_changed_one_is_the_users(drives, tmp_path):
    out, diary = tmp_path / "out", tmp_path / "diary"
    learn_fleet(drives("a", "b"), out, job=quick)
    path = out / "unfinished" / "a" / "learned.json"
    whole = path.read_bytes()
    path.write_bytes(whole[:100])
    resume = {"execution": Execution(resume=True), "job": Counting(diary)}
    with pytest.raises(UsageError, match=rf"{path}: was changed"):
        learn_fleet(drives("a", "b"), out, **resume)
    assert path.read_bytes() == whole[:100]
    path.unlink()
    learn_fleet(drives("a", "b"), out, **resume)
    assert diary.read_text().split() == ["a"]
    assert path.read_bytes() == whole


def test_files_of_the_user_survive_a_study_that_fails_and_resumes(drives, tmp_path):
    out = tmp_path / "out"
    mine = {out / "unfinished" / "notes.txt", out / "unfinished" / "b" / "notes.txt"}
    mine |= {out / "drives" / "b" / "notes.txt", out / "drives" / "d" / "learned.json"}
    for path in mine:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("mine")
    with pytest.raises(KeyboardInterrupt):
        learn_fleet(drives("a", "b", "c"), out, job=Counting(tmp_path / "diary", "c"))
    assert (out / "unfinished" / "b" / "learned.json").exists()
    assert written(out, drives("a", "b", "c"), execution=Execution(resume=True), job=quick).kept
    assert {
        path for path in out.rglob("*") if path.is_file() and path.read_bytes() == b"mine"
    } == mine
    assert {path for path in (out / "unfinished").rglob("*") if path.is_file()} < mine


@pytest.mark.parametrize("places", [["here"], ["here", "dask"]])
@pytest.mark.thorough
def test_a_fleet_is_the_same_in_processes_of_dask(
    log, places, request, tmp_path, capsys, monkeypatch
):
    table = tmp_path / "table.csv"
    shutil.copy(log, tmp_path)
    table.write_text("name,log\ngood,log.csv\nmissing,none.csv\n")
    module = "stickslip.studies.fleet.study.learn_fleet"
    monkeypatch.setattr(module, partial(learn_fleet, job=brief))
    for name in places:
        options = ["--workers", "1"]
        if name == "dask":
            options = ["--cluster", request.getfixturevalue("cluster")]
        assert main(["fleet", str(table), "--out", str(tmp_path / name), *options]) == 1
        out, error = capsys.readouterr()
        assert "missing  failed: none.csv: cannot be read" in out
        assert error.count("\n") == 1
        processes = {(tmp_path / f"{one}.pid").read_text() for one in ("good", "missing")}
        assert (processes == {str(os.getpid())}) == (name == "here")
        assert "1 of 2 drives failed" in error
    results = files(tmp_path / "here")
    names = {f"fleet.{ending}" for ending in ("csv", "html", "json", "png", "svg")}
    names |= {"learned.json", "manifest.json", "summary.csv"}
    assert {path.name for path in results} == names
    assert all(files(tmp_path / name) == results for name in places)
    rows = pd.read_csv(tmp_path / "here" / "fleet.csv").set_index(["name", "parameter"])
    assert rows["value"]["good", "m"] == pytest.approx(8.0, rel=0.05)  # 2 s at 1 kHz
    assert rows["value"]["good", "F_c"] == pytest.approx(4.0, rel=0.05)
    assert rows["low"]["good", "m"] < rows["value"]["good", "m"] < rows["high"]["good", "m"]
    assert rows["unit"]["good", "F_c"] == "N"
    assert rows.loc["missing"]["reason"].item().startswith("none.csv: cannot be read")


def read(tmp_path, text):
    table = tmp_path / "table.csv"
    table.write_text(text, encoding="utf-8")
    return read_fleet(table)


@pytest.fixture
def drives(tmp_path):
    """Return a function that reads a table of drives from names; they have no log."""
    return lambda *names: read(tmp_path, "name,log\n" + "".join(f"{x},none.csv\n" for x in names))


def files(folder):
    """Return all files of a folder, by their places in it."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder): path.read_bytes() for path in found}


def test_rows_become_drives_with_paths_beside_the_table(tmp_path):
    text = '\ufeffname,config,log\none, one.toml ,logs/one.csv\n\n"two",,"/logs/a,b.mat"\n'
    one, two = read(tmp_path, text)
    assert one.files == {"log": tmp_path / "logs/one.csv", "config": tmp_path / "one.toml"}
    assert {key: path.as_posix() for key, path in two.files.items()} == {"log": "/logs/a,b.mat"}
    assert one.row == {"name": "one", "log": "logs/one.csv", "config": "one.toml"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,log,log\na,b,c\n", "column 'log' is there twice"),
        ("name,config\na,b\n", "expected columns name and log, got name, config"),
        ("name,log\na,b\n,c\n", "row 3, column name: expected letters.*got nothing"),
        ("name,log,config\na,,c\n", "row 2, column log: expected the log .*got nothing"),
    ],
)
def test_a_bad_table_is_refused_in_one_line(tmp_path, text, message):
    """Others are among the hostile inputs."""
    with pytest.raises(UsageError, match=message) as refused:
        read(tmp_path, text)
    assert str(refused.value).startswith(str(tmp_path / "table.csv"))
    assert "\n" not in str(refused.value)
