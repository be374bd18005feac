"""The checker, which has readers of its own, reports hostile files as well, and survives them."""

import os
import sys
import warnings

import pytest

from stickslip import fmucheck
from stickslip.cli import main
from tests.corpus.hostile import CASES, archives, fmus
from tests.corpus.hostile.sound import members
from tests.corpus.hostile.zips import zipped

DESCRIPTIONS = [case for case in CASES if 5 <= case.group <= 13]
LAWFUL = {
    "12-length-set": "as long as that",
    "11-times-no-time": "as DefaultExperiment of 0 and 0, which exporters write for none",
    **dict.fromkeys(
        (f"11-times-{name}" for name in ("too-many", "memory", "huge")),
        "a long experiment, not a fault of the FMU",
    ),
}
"""What a run refuses, though nothing is wrong with the FMU."""


def faults(path) -> set[str]:
    report = fmucheck.check(path, run=False)
    assert [f.severity for f in report] == sorted((f.severity for f in report), reverse=True)
    return {f.rule for f in report if f.severity >= fmucheck.Severity.WARNING}


@pytest.fixture(scope="module")
def in_the_sound(tmp_path_factory) -> set[str]:
    """Return what is found in the file that hostile ones are made from."""
    path = tmp_path_factory.mktemp("sound") / "sound.fmu"
    path.write_bytes(zipped(members()))
    return faults(path)


@pytest.mark.parametrize("case", [*archives.CASES, *DESCRIPTIONS], ids=str)
def test_a_hostile_file_is_found_at_fault(case, in_the_sound, tmp_path, capsys):
    with warnings.catch_warnings(action="ignore"):  # zipfile: two members of one name
        file = tmp_path / case.make(tmp_path)[1]
    new = faults(file) - in_the_sound
    assert bool(new) != (str(case) in LAWFUL)
    if case in archives.CASES:
        assert main(["check", "--no-run", "--strict", str(file)]) == 1
        told = capsys.readouterr()
        assert "Traceback" not in told.out + told.err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
@pytest.mark.parametrize("name", ["pipe", "device", "link to a device", "folder"])
def test_what_is_no_file_is_not_read(name, tmp_path, capsys):
    path = tmp_path / "a.fmu"
    if name == "pipe":
        os.mkfifo(path)
    elif name == "device":
        path = "/dev/zero"
    elif name == "folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/zero")
    assert main(["check", str(path)]) == 1
    assert "not-a-zip" in capsys.readouterr().out


@pytest.mark.skipif(sys.platform == "win32", reason="hostile.c is for POSIX")
def test_what_an_fmu_writes_into_the_report_is_not_read(tmp_path):
    """The findings are those of the same FMU that writes nowhere, but for what it printed."""
    found = []
    for behaves in ("", *(f"Instantiate scribble{how}" for how in ("", "_lines", "_frame"))):
        report = fmucheck.check(fmus.write(tmp_path / "hostile.fmu", behaves))
        found.append({(f.rule, f.place) for f in report if "print" not in f.rule})
    assert found == 4 * found[:1]
