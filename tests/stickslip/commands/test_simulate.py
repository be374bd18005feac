"""Inputs, results, values by name and states of stickslip simulate."""

import json
import re

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from stickslip import cosim
from stickslip.cli import main
from stickslip.fmi.messages import named
from tests.corpus.hostile.sound import describe, replaced
from tests.corpus.hostile.zips import zipped
from tests.cosim.single import edited

TIMES = ["--stop", "0.02", "--step", "0.001"]


def simulate(*arguments):
    return main(["simulate", *map(str, arguments), *TIMES])


@pytest.fixture
def force(tmp_path, stage):
    """Write an input that jumps, and return its name and the file."""
    (name,) = (v.name for v in cosim.Fmu(stage).variables.values() if v.causality == "input")
    frame = pd.DataFrame({"time": [0.0, 0.01, 0.02], name: [0.0, 20.0, 40.0]})
    path = tmp_path / "in.parquet"
    frame.to_parquet(path)
    return name, path


def test_parquet_goes_in_and_comes_out(stage, force, tmp_path):
    name, path = force
    simulate(stage, "--input", path, "--out", tmp_path / "linear.parquet")
    simulate(stage, "--input", path, "--hold", name, "--out", tmp_path / "held.csv")
    linear = pd.read_parquet(tmp_path / "linear.parquet")[name]
    held = pd.read_csv(tmp_path / "held.csv")[name]
    assert linear[5] == pytest.approx(10.0)
    assert np.unique(held).tolist() == [0.0, 20.0, 40.0]


def test_an_input_that_ends_before_the_run_is_warned_of(stage, force, capsys):
    name, path = force
    for more, expected in (([], 1), (["--hold", name], 0)):
        main(["simulate", str(stage), "--input", str(path), "--stop", "0.5", *more])
        found = capsys.readouterr().err.count("ends at 0.02 s; its last values hold until 0.5 s")
        assert found == expected


def test_a_run_is_saved_and_resumed(stage, force, tmp_path):
    _, path = force
    state = tmp_path / "half.state"
    simulate(stage, "--input", path, "--out", tmp_path / "whole.csv")
    simulate(stage, "--input", path, "--until", "0.01", "--save", state)
    simulate(stage, "--input", path, "--resume", state, "--out", tmp_path / "rest.csv")
    whole, rest = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("whole", "rest"))
    pd.testing.assert_frame_equal(whole[10:].reset_index(drop=True), rest, check_exact=True)


@pytest.mark.parametrize("every", [1, 7])
def test_a_resumed_run_writes_its_file_as_it_goes(stage, every, tmp_path):
    system = cosim.System()
    system.add("stage", stage)
    system.set("stage.u", 30.0)
    how = {"stop": 40.0, "step": 1e-3, "record": cosim.Record(None, every, "range")}
    with system.prepare(**how) as simulation:
        simulation.run(out=tmp_path / "whole.csv")
        simulation.run(until=14.003)
        simulation.save(tmp_path / "state")
        rest = simulation.resume(tmp_path / "state", out=tmp_path / "rest.csv")
    whole, found = ((tmp_path / f"{n}.csv").read_text().splitlines() for n in ("whole", "rest"))
    assert found == [whole[0], *whole[1 - (-14_003 // every) :]]
    assert rest.points == len(found) - 1


def test_an_fmu_of_another_tool_with_dots_in_names_and_no_step(stage, force, tmp_path):
    name, path = force
    changes = {f'name="{name}"': f'name="axis.{name}"', r' stepSize="[^"]*"': ""}
    fmu = edited(stage, tmp_path / "other.fmu", changes)
    frame = pd.read_parquet(path)
    frame.rename(columns={name: f"axis.{name}"}).to_parquet(tmp_path / "dots.parquet")
    simulate(stage, "--input", path, "--out", tmp_path / "plain.csv")
    assert simulate(fmu, "--input", tmp_path / "dots.parquet", "--out", tmp_path / "dots.csv") == 0
    plain, dots = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("plain", "dots"))
    np.testing.assert_array_equal(plain.to_numpy(), dots.to_numpy())
    assert main(["simulate", str(fmu), "--stop", "0.5", "--out", str(tmp_path / "free.csv")]) == 0
    assert len(pd.read_csv(tmp_path / "free.csv")) == 501


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--variant", "x"], "a variant names a system of an .ssp"),
        (["--hold", "u"], "--hold names columns of --input"),
        (["--timeout", "0"], "timeout is 0.0, expected a positive number$"),
        (["--set", "m=1_0"], r"m: expected a value of type \w+, got '1_0'$"),
        (["--tolerance", "2"], "tolerance is 2.0, expected a number between 0 and 1$"),
    ],
)
def test_an_invalid_option_is_named(stage, arguments, says, capsys):
    assert simulate(stage, *arguments) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(says, line)


@pytest.mark.parametrize(
    ("column", "says"),
    [("", "a column for an exposed input (u) beside 'time'"), (",u [mN]", "'u', with values in N")],
)
def test_a_table_without_a_signal_is_refused(stage, column, says, tmp_path, capsys):
    table = tmp_path / "table.csv"
    table.write_text(f"time{column}\n" + "".join(f"{t}{',1' * bool(column)}\n" for t in (0, 1)))
    assert simulate(stage, "--input", table) == 1
    assert capsys.readouterr().err.endswith(f"{says}\n")


def test_a_state_is_not_saved_into_a_folder(stage, tmp_path, capsys):
    (tmp_path / "a.state").mkdir()
    assert simulate(stage, "--until", "0.01", "--save", tmp_path / "a.state") == 1
    assert re.fullmatch(r"stickslip: \S+a.state: is a folder.*\n", capsys.readouterr().err)


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


@pytest.mark.parametrize(
    ("cell", "says"),
    [("1 2", "expected 3 numbers as in the first row, got 2"), ("1 x 2", "expected a finite")],
)
def test_a_cell_of_another_length_names_line_and_column(tmp_path, cell, says):
    path = tmp_path / "in.csv"
    path.write_text(f"time,u\n0,1 2 3\n1,{cell}\n")
    with pytest.raises(cosim.SignalError) as error:
        ss.read_tables(path)
    assert "line 3: column 'u" in str(error.value)
    assert says in str(error.value)


def test_references_in_messages_are_names():
    variables = [("Real", 12, "x"), ("Integer", 12, "n"), ("Boolean", 0, "on")]
    text = "#r12# is above #i12##b0#: 50 ##, #r99#"
    assert named(text, variables) == "x is above non: 50 #, #r99#"
