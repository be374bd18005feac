"""The command that is given strangers' FMUs keeps them apart without being asked."""

import sys

import pytest

from benchmarks.hostile import fmus
from stickslip.cli import main

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="apart by default on Linux only")


def test_an_fmu_that_ends_its_process_does_not_end_the_command(tmp_path, capfd):
    path = fmus.write(tmp_path / "quits.fmu", "DoStep exit0 3")
    assert main(["simulate", str(path)]) == 1
    assert "DoStep ended its process with status 0" in capfd.readouterr().err


def test_apart_or_not_the_results_are_the_same(tmp_path):
    path = fmus.write(tmp_path / "sound.fmu")
    tables = []
    for how in ("--isolate", "--no-isolate"):
        out = tmp_path / f"{how}.csv"
        assert main(["simulate", str(path), how, "--out", str(out)]) == 0
        tables.append(out.read_bytes())
    assert tables[0] == tables[1]


def test_limits_need_something_to_limit(tmp_path, capfd):
    path = fmus.write(tmp_path / "sound.fmu")
    assert main(["simulate", str(path), "--no-isolate", "--timeout", "5"]) == 1
    assert "--timeout needs --isolate" in capfd.readouterr().err
