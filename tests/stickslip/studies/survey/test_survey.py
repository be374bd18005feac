"""``stickslip survey``: each outcome of a run, with made FMUs."""

import json

import numpy as np
import pytest

from stickslip import models
from stickslip.cli import main
from stickslip.studies.survey.runs import RunOutcome, compare
from tests.corpus.hostile import fmus
from tests.corpus.hostile.sound import describe, members, replaced
from tests.corpus.hostile.zips import zipped


@pytest.mark.slow
def test_each_run_has_its_outcome(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "in"
    folder.mkdir()
    models.build_fmu("stage", folder)
    (folder / "copy.fmu").write_bytes((folder / "stage.fmu").read_bytes())  # of one content
    (folder / "reference.fmu").write_bytes(zipped(members()))
    version = ('fmiVersion="2.0"', 'fmiVersion="4.0"')
    (folder / "refused.fmu").write_bytes(zipped(describe(replaced(2, version))))
    fmus.write(folder / "quits.fmu", "DoStep exit0 3")
    out = tmp_path / "out"
    arguments = ["survey", "in", "--with", "fmpy", "--out", str(out), "--json"]
    assert main(arguments) == 0
    document = json.loads(capsys.readouterr().out)
    found = {run["file"]: run["outcome"] for run in document["runs"]}
    assert found["reference.fmu"] in {"equal", "near"}
    assert found["refused.fmu"] == "works in neither"
    assert found["quits.fmu"] in {"works in neither", "works in FMPy only"}
    assert ("copy.fmu" in found) != ("stage.fmu" in found)
    assert sum(document["counts"].values()) == len(document["runs"])
    assert len((out / "survey.csv").read_text().splitlines()) == len(document["runs"]) + 1


def test_a_folder_without_files_is_an_error(tmp_path, capsys):
    assert main(["survey", str(tmp_path)]) == 1
    assert "there is no .fmu and no .ssp file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("theirs", "verdict"),
    [
        ([1.0, np.inf, np.nan], "equal"),
        ([1.0, -np.inf, np.nan], "different"),
        ([1.0, np.inf, 1.0], "different"),
        ([1.0 + 1e-6, np.inf, np.nan], "near"),
    ],
)
def test_infinite_values_and_none_are_compared(theirs, verdict):
    time = np.arange(3.0)
    same = np.ones(3)
    ours = RunOutcome(time=time, signals={"y": np.array([1.0, np.inf, np.nan]), "z": same})
    other = RunOutcome(time=time, signals={"y": np.array(theirs), "z": same})
    assert compare(ours, other)[0] == verdict
