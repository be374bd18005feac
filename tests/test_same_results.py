"""The comparison of two commits' results finds what differs."""

import json

import pytest

from tests.same_results import compare

LEARNED = {
    "parameters": {"F_c": {"value": 6.0, "unit": "N", "sentence": "well known"}},
    "trial": [{"worse": False}],
    "versions": {"numpy": "1"},
}


def outcomes(tmp_path, old, new):
    for name, files in (("old", old), ("new", new)):
        (tmp_path / name / "drive").mkdir(parents=True)
        for file, text in files.items():
            (tmp_path / name / "drive" / file).write_text(text)
    found = list(compare(tmp_path / "old", tmp_path / "new"))
    return {row.name.removeprefix("drive/"): (row.result, row.detail) for row in found}


def learned(**changed):
    return json.dumps(LEARNED | changed)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("a,b\n1,2\n", "a,b\n1,2\n", ("equal", "")),
        ("a,b\n1,2\n", "a,b\n1,2.0\n", ("DIFFERS", "row 2: 1,2 against 1,2.0")),
        ("a,b\n1,2\n", "a,b\n", ("DIFFERS", "2 rows against 1")),
        ("a\n1\n", "a\r\n1\r\n", ("DIFFERS", "the same rows in other bytes")),
    ],
)
def test_tables_are_equal_to_the_byte(tmp_path, old, new, expected):
    assert outcomes(tmp_path, {"t.csv": old}, {"t.csv": new})["t.csv"] == expected


def test_a_missing_table_differs_and_a_new_one_does_not(tmp_path):
    assert outcomes(tmp_path, {"t.csv": ""}, {"u.csv": ""}) == {
        "t.csv": ("DIFFERS", "missing in the second"),
        "u.csv": ("new", "only in the second"),
    }


@pytest.mark.parametrize(
    ("changed", "result"),
    [
        ({"versions": {"numpy": "2"}}, "equal"),
        ({"parameters": {"F_c": {"value": 6.0, "unit": "N", "sentence": "other"}}}, "equal"),
        ({"more": 1}, "equal"),
        ({"parameters": {"F_c": {"value": 6.1, "unit": "N", "sentence": "well known"}}}, "DIFFERS"),
        ({"parameters": {"F_c": {"value": 6.0, "unit": "kN", "sentence": "other"}}}, "DIFFERS"),
        ({"parameters": {"F_c": {"unit": "N"}}}, "DIFFERS"),
        ({"trial": [{"worse": True}]}, "DIFFERS"),
        ({"trial": [{"worse": 0}]}, "DIFFERS"),
    ],
)
def test_learned_values_are_equal(tmp_path, changed, result):
    found = outcomes(tmp_path, {"learned.json": learned()}, {"learned.json": learned(**changed)})
    assert found["learned.json"][0] == result
