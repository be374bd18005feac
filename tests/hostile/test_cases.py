"""Each hostile input ends in one line that states the fault; campaigns/fuzz.py hunts for more."""

import logging
import re
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import pytest

from campaigns.fuzz import PARSERS, run
from stickslip.cli import main
from stickslip.fmi.toolchain import cache_directory
from tests.corpus.hostile import CASES, GROUPS, Case, descriptions, fmus, python, xml

LIBRARIES = cache_directory() / "libraries"
"""Nothing has to be compiled again."""


def litter(*folders: Path) -> set[Path]:
    """Return what must not grow: temporary files, and half-unpacked archives in the cache."""
    found = set(Path(tempfile.gettempdir()).iterdir())
    for folder in folders:
        found |= set(folder.rglob(".*"))
    return found


def test_each_case_has_a_name_of_its_own_and_a_group():
    assert len({str(case) for case in CASES}) == len(CASES)
    assert {case.group for case in CASES} <= set(GROUPS)
    assert {str(case) for case in CASES} > FURTHER


SOUND_BINARIES = {17, 18, 19}
"""Groups of FMUs that leave their process as it is; only the first of each is run in a child."""
FIRST = {group: next(case for case in CASES if case.group == group) for group in GROUPS}


FURTHER = {
    *("14-text", "14-cut-short", "15-null", "16-constructor-exit", "16-constructor-hang"),
    *("16-initialise-hang", "16-step-crash", "16-stack-overflow", "16-log-flood"),
    *("17-error-at-DoStep-2", "17-five-at-DoStep-3", "17-fatal-at-EnterInitializationMode-2"),
    *("20-second-crashes", "22-log-mat-cells", "22-log-mat-damaged", "29-kill-parent"),
}
"""Cases that start a process and end as another one does, or as tests/cosim shows."""


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=pytest.mark.thorough if str(case) in FURTHER else (), id=str(case))
        for case in CASES
    ],
)
def test_a_hostile_input_ends_in_one_line(case: Case, tmp_path, monkeypatch, capfd):
    cache = tmp_path / "cache"
    cache.mkdir()
    (cache / "libraries").symlink_to(LIBRARIES)
    monkeypatch.setenv("STICKSLIP_CACHE", str(cache))
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))  # where others leave nothing
    monkeypatch.setattr(tempfile, "tempdir", None)
    folder = tmp_path / "fed"
    folder.mkdir()
    with warnings.catch_warnings(action="ignore"):  # zipfile: two members of one name
        arguments = case.make(folder)
    if case.group in SOUND_BINARIES and case is not FIRST[case.group]:
        arguments.append("--no-isolate")
    monkeypatch.chdir(folder)
    before, fed = litter(cache), set(folder.rglob("*"))
    try:
        status = python.run(case.code) if case.code else main(arguments)
    except SystemExit as usage:
        status = usage.code
    said = capfd.readouterr().err.splitlines()
    assert status in {1, 2}
    assert len(said) == 1, said
    assert re.match(r"stickslip: .*" + case.says, said[0]), said
    assert litter(cache) == before
    assert set(folder.rglob("*")) == fed


@pytest.mark.parametrize("case", [*xml.TOLERATED, *descriptions.TOLERATED], ids=str)
def test_what_no_run_needs_is_a_warning(case: Case, tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    arguments = case.make(tmp_path)
    assert main([*arguments, "--no-isolate"]) == 0
    out, err = capfd.readouterr()
    assert "reference.y " in out
    said = err.splitlines()
    assert all(line.startswith("stickslip: warning: ") for line in said)
    assert [line for line in said if re.search(case.says, line)]
    assert len(set(said)) == len(said)  # once each
    assert main(["info", *arguments[1:]]) == 0
    assert re.search(case.says, capfd.readouterr().out)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="closes file descriptors")
@pytest.mark.parametrize("how", ["--isolate", "--no-isolate"])
def test_closed_standard_streams_change_nothing(tmp_path, how):
    path, out = fmus.write(tmp_path / "prints.fmu", "DoStep scribble_standard"), tmp_path / "o.csv"
    command = f"{sys.executable} -m stickslip simulate {path} {how} --out {out} 0<&- 1>&- 2>&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True)  # noqa: S602
    assert done.returncode == 0, done.stderr
    assert out.read_text().startswith("time,u,hostile.y\n")
    assert "Traceback" not in done.stderr


N = {"mat": 8, "log_csv": 40, "ssp": 30}  # each starts a process, or unpacks two FMUs
TEXTS = ("description", "csv", "config", "learned", "checkpoint")
N |= dict.fromkeys((*TEXTS, "library", "state"), 250)


@pytest.mark.slow
@pytest.mark.parametrize("name", PARSERS)
def test_mutated_inputs_are_taken_or_refused(name, tmp_path, caplog):
    caplog.set_level(logging.CRITICAL)
    parser = PARSERS[name]
    for data in parser.sound():  # else all that is made of it would be refused for one reason
        file = tmp_path / parser.file
        file.write_bytes(data)
        parser.read(file)
    tally = run(parser, 0, range(N.get(name, 100)))
    assert not tally.unexpected
    assert tally.accepted > 0
    assert tally.refused > 0
