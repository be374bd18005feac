"""``stickslip survey``: each outcome of a run, with an FMU that has it."""

import json
import os
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from stickslip.cli import main
from stickslip.studies.survey.runs import RunOutcome, apart, compare, verdict
from tests.corpus import fmu
from tests.corpus.fmu import Variable

ALONE = {
    "equal": "ran",
    "near": "ran",
    "different": "ran",
    "no common output": "ran",
    "works here only": "ran",
    "second run differs": "second run differs",
    "works in FMPy only": "died",
    "died": "died",
    "refused": "refused",
    "no binary": "no binary",
}
"""Behaviour, which is what FMPy makes of it -> outcome of the master alone."""
WITH_FMPY = {"died": "works in neither", "refused": "works in neither"}
"""Those of them that both tools cannot run."""


def write(path, behaviour):
    """Write an FMU of ``outcomes.c``."""
    library = fmu.library("outcomes", Path(__file__).with_name("outcomes.c"), versions=(2,))
    has_none = behaviour == "no common output"
    variables = [Variable("u", "input", 0.0)] if has_none else [Variable("y", "output")]
    description = fmu.describe(
        "outcomes",
        2,
        variables,
        {"CoSimulation": ""},
        token=behaviour,
        experiment='stopTime="1" stepSize="0.1"',
    )
    if behaviour == "refused":
        description = description.replace('fmiVersion="2.0"', 'fmiVersion="4.0"')
    files = {fmu.place("outcomes", 2): library.read_bytes()}
    return fmu.pack(path, description, {} if behaviour == "no binary" else files)


@pytest.mark.slow
@pytest.mark.parametrize("fmpy", [True, False])
def test_each_run_has_its_outcome(fmpy, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for behaviour in ALONE:
        write(tmp_path / "in" / f"{behaviour}.fmu", behaviour)
    shutil.copy(tmp_path / "in" / "equal.fmu", tmp_path / "in" / "of the content of another.fmu")
    other = ["--with", "fmpy"] if fmpy else []
    assert main(["survey", "in", *other, "--workers", "2", "--out", "out", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    found = {run["file"].removesuffix(".fmu"): run["outcome"] for run in document["runs"]}
    assert found == ({name: WITH_FMPY.get(name, name) for name in ALONE} if fmpy else ALONE)
    assert document["counts"]["works in neither" if fmpy else "died"] == 2
    assert len((tmp_path / "out" / "survey.csv").read_text().splitlines()) == len(found) + 1
    assert "no binary for this machine" in (tmp_path / "out" / "survey.html").read_text()


@pytest.mark.thorough
@pytest.mark.slow
def test_a_run_has_limited_time(tmp_path, capsys):
    write(tmp_path / "a.fmu", "out of time")
    assert main(["survey", str(tmp_path), "--timeout", "3", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"] == {"out of time": 1}


def closes_all_files():
    os.closerange(3, 1000)
    yield time.sleep(60)


def test_a_run_that_closes_all_files_is_ended():
    assert apart(closes_all_files, limit=60.0).fault == "died: SIGKILL"


def test_a_module_that_fmpy_lacks_is_named():
    theirs = RunOutcome("ModuleNotFoundError: No module named 'lark'")
    assert verdict(RunOutcome(), theirs, fmpy=True)[0] == "FMPy lacks lark"


def test_a_folder_without_files_is_an_error(tmp_path, capsys):
    assert main(["survey", str(tmp_path)]) == 1
    assert "there is no .fmu and no .ssp file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("theirs", "outcome"),
    [
        ([1.0, np.inf, np.nan], "equal"),
        ([1.0, -np.inf, np.nan], "different"),
        ([1.0, np.inf, 1.0], "different"),
        ([1.0 + 1e-6, np.inf, np.nan], "near"),
    ],
)
def test_infinite_values_and_none_are_compared(theirs, outcome):
    time = np.arange(3.0)
    same = np.ones(3)
    ours = RunOutcome(time=time, signals={"y": np.array([1.0, np.inf, np.nan]), "z": same})
    other = RunOutcome(time=time, signals={"y": np.array(theirs), "z": same})
    assert compare(ours, other)[0] == outcome
