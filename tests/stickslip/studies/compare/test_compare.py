"""``stickslip compare``: what several results say, side by side."""

import json
import re

import pandas as pd
import pytest

from stickslip.cli import main
from stickslip.presentation.table import Column
from stickslip.studies.compare import compared, tables

N = "N"


def learned(folder, value, half, **entries):
    """Write a learned.json with F_c and its interval."""
    folder.mkdir(parents=True)
    level = "identifiable" if half else "not identifiable"
    one = {"value": value, "unit": N, "standard_error": half / 2, "identifiability": level}
    one |= {"low": value - half, "high": value + half}
    document = {"schema": 2, "parameters": {"F_c": one}, **entries}
    (folder / "learned.json").write_text(json.dumps(document))
    return str(folder)


def test_values_intervals_and_error_ratios_stand_side_by_side(tmp_path, capsys):
    rows = [
        {"compensator": "lugre", "share": 0.8, "fitted": 0.5, "worst": 0.9},
        {"compensator": "ekbf", "share": None, "fitted": 0.3, "worst": 0.7},
    ]
    tried = {"compensation": "observer", "compared": {"chosen": "ekbf", "compensators": rows}}
    places = [
        learned(tmp_path / "axis" / "new", 6.0, 0.1, **tried),
        learned(tmp_path / "axis" / "old", 5.0, 0.2, law="dahl", refusal="worse"),
        learned(tmp_path / "other", 6.15, 0.1),
        learned(tmp_path / "fleet" / "drives" / "unseen", 1.0, 0.0),
    ]
    places[-1] = str(tmp_path / "fleet")
    out = tmp_path / "out"
    assert main(["compare", *places, "--out", str(out)]) == 0
    line, *_, by_new, by_old, _, _ = (
        capsys.readouterr().out.split("all results")[0].splitlines()[2:-1]
    )
    assert line.split()[:2] == ["F_c", "[N]"]
    assert "6 [5.9, 6.1]" in line
    assert "5 [4.8, 5.2]" in line
    assert "(1)" in line  # not identifiable
    assert line.endswith(" old")  # apart from the first, which the third is not
    assert by_new.split() == ["new", "lugre", "observer", "-", "0.3", "0.7"]
    assert by_old.split() == ["old", "dahl", "none:", "refused", "-", "-", "-"]
    table = pd.read_csv(out / "parameters.csv")
    assert list(table["value"]) == [6.0, 5.0, 6.15, 1.0]
    assert "Values with their 95 % intervals" in (out / "compare.html").read_text()
    assert main(["verify", str(out)]) == 0


def test_results_without_intervals_are_compared_too(tmp_path):
    bare = {"schema": 2, "parameters": {"F_c": {"value": 6.0, "unit": N}}}
    (tmp_path / "learned.json").write_text(json.dumps(bare))
    assert main(["compare", str(tmp_path), "--out", str(tmp_path / "out")]) == 0
    (row,) = pd.read_csv(tmp_path / "out" / "parameters.csv").to_dict("records")
    assert (row["value"], pd.isna(row["low"])) == (6.0, True)


def test_results_of_one_name_are_told_apart_by_their_folders(tmp_path, capsys):
    places = [learned(tmp_path / name / "run", 6.0, 0.1) for name in ("a", "b")]
    assert main(["--json", "compare", *places]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in document["errors"]] == ["a/run", "b/run"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "expected learned.json, or a folder in which learn, reproduce or fleet wrote one"),
        ('{"parameters": {"F_c": 3}}', "is no result of learn, reproduce or fleet"),
        ("[]", "is no result of learn, reproduce or fleet"),
        ('{"parameters": {"F_c": {"value": "x"}}}', "is no result of learn, reproduce or fleet"),
        ('{"parameters": {"F_c": {}}}', "is no result of learn, reproduce or fleet"),
        ("{", "learned.json: "),
    ],
)
def test_what_is_no_result_is_one_line(tmp_path, capsys, content, message):
    if content is not None:
        (tmp_path / "learned.json").write_text(content)
    assert main(["compare", str(tmp_path), "--out", str(tmp_path / "out")]) in (1, 2)
    error = capsys.readouterr().err
    assert message in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "out").exists() or not [*(tmp_path / "out").iterdir()]


def test_the_same_result_twice_is_refused(tmp_path, capsys):
    place = learned(tmp_path / "a", 6.0, 0.1)
    assert main(["compare", place, place]) in (1, 2)
    assert "the same result is named twice" in capsys.readouterr().err


def test_a_further_column_is_on_terminal_page_and_in_files(tmp_path, capsys, monkeypatch):
    further = Column("further", ".3g", "further", "Further")
    monkeypatch.setattr(tables, "ERRORS", (*tables.ERRORS, further))
    monkeypatch.setattr(compared, "error_ratios", lambda _: {"further": 0.75})
    place, out = learned(tmp_path / "a", 6.0, 0.1), tmp_path / "out"
    assert main(["compare", place, "--out", str(out)]) == 0
    assert re.search(r"worst +further\n.* 0\.75\n", capsys.readouterr().out)
    assert list(pd.read_csv(out / "errors.csv")["further"]) == [0.75]
    page = (out / "compare.html").read_text()
    assert page.index(">Further<") < page.index(">0.75<")
    assert main(["--json", "compare", place]) == 0
    assert json.loads(capsys.readouterr().out)["errors"][0]["further"] == 0.75
