"""A true learning of a short log, the same bytes wherever it runs."""

from dataclasses import replace

import pandas as pd
import pytest

from stickslip.cli import main
from stickslip.planning import LINEAR, plan

pytestmark = pytest.mark.slow

SHORT = replace(LINEAR, duration=2.0)


def test_a_fleet_is_the_same_in_processes_of_dask(log, cluster, files, tmp_path, capsys):
    table = tmp_path / "table.csv"
    table.write_text(f"name,log\ngood,{log}\nmissing,none.csv\n")
    where = {
        "here": ["--workers", "1"],
        "dask": ["--cluster", cluster],
    }
    for name, options in where.items():
        assert main(["fleet", str(table), "--out", str(tmp_path / name), *options]) == 1
        out, error = capsys.readouterr()
        assert "missing  failed: none.csv: cannot be read" in out
        assert error.count("\n") == 1
        assert "1 of 2 drives failed" in error
    results = files(tmp_path / "here")
    names = {f"fleet.{ending}" for ending in ("csv", "html", "json", "png", "svg")}
    names |= {"learned.json", "manifest.json", "summary.csv"}
    assert {path.name for path in results} == names
    assert files(tmp_path / "dask") == results
    rows = pd.read_csv(tmp_path / "here" / "fleet.csv").set_index(["name", "parameter"])
    assert rows["value"]["good", "m"] == pytest.approx(8.0, rel=0.05)  # 2 s at 1 kHz
    assert rows["value"]["good", "F_c"] == pytest.approx(4.0, rel=0.05)
    assert rows["low"]["good", "m"] < rows["value"]["good", "m"] < rows["high"]["good", "m"]
    assert rows["unit"]["good", "F_c"] == "N"
    assert rows.loc["missing"]["reason"].item().startswith("none.csv: cannot be read")


def test_a_variant_is_recorded_and_its_truth_joined(tmp_path, monkeypatch):
    monkeypatch.setattr("stickslip.studies.learn.recorded.plan", lambda *_: plan(SHORT))
    table = tmp_path / "table.csv"
    table.write_text("name,set\nheavy,drive.m=9\n")
    assert main(["fleet", str(table), "--out", str(tmp_path / "out")]) == 0
    rows = pd.read_csv(tmp_path / "out" / "fleet.csv").set_index("parameter")
    assert rows["truth"]["m"] == 9.0
    assert rows["value"]["m"] == pytest.approx(9.0, rel=1e-3)
    assert rows["value"]["m"] != 9.0
    assert set(rows["criterion"]) == {"output error"}
    learned = (tmp_path / "out" / "drives" / "heavy" / "learned.json").read_text()
    assert "truth" not in learned
