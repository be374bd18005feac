"""Enumerations by the names of their items, arrays in a cell, names of variables in messages."""

import csv
import json

import numpy as np
import pytest

import stickslip as ss
from stickslip import cosim
from stickslip.cli import main
from stickslip.fmi.messages import named
from tests.corpus.hostile.sound import describe, replaced
from tests.corpus.hostile.zips import zipped


@pytest.fixture(scope="module", params=[2, 3])
def sound(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("named") / "a.fmu"
    path.write_bytes(zipped(describe(replaced(request.param), request.param)))
    return path


def ends(path, *arguments, capsys):
    assert main(["simulate", str(path), "--record", "mode", "--json", *arguments]) == 0
    return json.loads(capsys.readouterr().out)["signals"][0]["end"]


def test_an_enumeration_is_set_by_the_name_of_an_item(sound, capsys):
    assert ends(sound, "--set", "mode=second", capsys=capsys) == 2
    assert ends(sound, "--set", "mode=1", capsys=capsys) == 1
    result = ss.simulate(sound, parameters={"mode": "second"}, record=["mode"])
    assert result["mode"][-1] == 2
    last = {"end": lambda result: result["mode"][-1]}
    table = ss.sweep(sound, {"mode": ["first", "second"]}, last, record=["mode"])
    assert list(table["end"]) == [1, 2]
    assert main(["simulate", str(sound), "--set", "mode=secnd"]) == 1
    assert "did you mean 'second'?" in capsys.readouterr().err


def test_info_lists_the_items(sound, capsys):
    assert main(["info", str(sound)]) == 0
    assert "first = 1, second = 2" in capsys.readouterr().out
    rows = ss.info(sound).variables.set_index("name")
    assert rows["items"]["mode"] == ["first = 1", "second = 2"]


def rows_of(path, *header, cells):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([["time", *header], *cells])
    return path


@pytest.mark.parametrize("blank", [" ", "  ", "\t"])
def test_a_cell_holds_an_array_row_by_row(tmp_path, blank):
    path = rows_of(
        tmp_path / "in.csv",
        *("u", "v"),
        cells=[[t, blank.join(["1", str(t), "-3e0"]), t] for t in (0, 1, 2)],
    )
    tables = ss.read_tables(path, ["u"])
    assert list(tables) == ["u[1]", "u[2]", "u[3]", "v"]
    np.testing.assert_array_equal(tables["u[2]"].values, [0, 1, 2])
    assert [table.held for table in tables.values()] == [True, True, True, False]


@pytest.mark.parametrize(
    ("cell", "says"),
    [("1 2", "expected 3 numbers as in the first row, got 2"), ("1 x 2", "expected a finite")],
)
def test_a_cell_of_another_length_names_line_and_column(tmp_path, cell, says):
    path = rows_of(tmp_path / "in.csv", "u", cells=[[0, "1 2 3"], [1, cell]])
    with pytest.raises(cosim.SignalError) as error:
        ss.read_tables(path)
    assert "line 3: column 'u" in str(error.value)
    assert says in str(error.value)


def test_references_in_messages_are_names():
    variables = [("Real", 12, "x"), ("Integer", 12, "n"), ("Boolean", 0, "on")]
    text = "#r12# is above #i12##b0#: 50 ##, #r99#"
    assert named(text, variables) == "x is above non: 50 #, #r99#"
