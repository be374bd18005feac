from __future__ import annotations

import sys

import numpy as np
import pandas as pd
import pytest

from stickslip import cosim

FRAME = pd.DataFrame({"time": [0.0, 1.0, 1.0, 2.0], "v": [0.0, 1.0, 5.0, 6.0], "w": [1, 2, 3, 4]})
T = np.array([-1.0, 0.5, 1.0, 1.5, 9.0])


def test_a_held_table_keeps_each_value_until_the_next_time():
    table = cosim.Table(FRAME["time"], FRAME["v"], held=True)
    assert table.sample(T).tolist() == [0.0, 0.0, 5.0, 5.0, 6.0]


@pytest.mark.parametrize("kind", ["frame", "index", "csv", "parquet"])
def test_all_sources_give_the_same_signals(tmp_path, kind):
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    source = tmp_path / f"in.{kind}"
    if kind == "csv":
        FRAME.to_csv(source, index=False)
    elif kind == "parquet":
        FRAME.to_parquet(source)
    else:
        source = FRAME.set_index("time") if kind == "index" else FRAME
    tables = cosim.read_tables(source, held=["w"])
    assert tables["v"].sample(T).tolist() == [0.0, 0.5, 5.0, 5.5, 6.0]
    assert tables["w"].sample(T).tolist() == [1.0, 1.0, 3.0, 3.0, 4.0]
    assert all(table.held for table in cosim.read_tables(source, held=True).values())


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (pd.DataFrame({"v": [1.0]}), "its index numbers the rows"),
        (pd.DataFrame(index=[0.0, 1.0]), "distinct columns beside 'time'"),
        (FRAME.assign(time=pd.date_range("2026-01-01", periods=4)), "'time' holds datetime64"),
        (FRAME * 1j, "holds complex128"),
        (FRAME.set_index(["time", "w"]), "several levels"),
        (pd.concat({"a": FRAME}, axis=1), "several levels"),
        (pd.DataFrame({"time": [0.0], "v": ["x"]}), "not a number"),
        (pd.DataFrame({"time": [1.0, 0.0], "v": [0.0, 0.0]}), "time falls"),
        (pd.DataFrame({"time": [0.0, 1.0], "v": [0.0, np.nan]}), "not finite"),
    ],
)
def test_frames_that_cannot_be(frame, message):
    with pytest.raises(cosim.SignalError, match=message):
        cosim.read_tables(frame)


@pytest.mark.parametrize("unit", [None, "s"], ids=["numbers", "differences of time"])
@pytest.mark.parametrize("kind", ["frame", "series", "column"])
def test_pandas_gives_inputs_as_tables_do(kind, unit):
    time = FRAME["time"].to_numpy()
    frame = FRAME[["v"]].set_axis(pd.to_timedelta(time, unit=unit) if unit else time)
    inputs = {"frame": frame, "series": {"v": frame["v"]}, "column": FRAME.drop(columns="w")}[kind]
    found = cosim.signals_of(inputs)["v"]
    assert found.sample(T).tolist() == cosim.Table(time, FRAME["v"]).sample(T).tolist()


def test_other_inputs_stay_what_they_are():
    given = {"a": 1.0, "b": [0.0, 1.0], "c": np.sin, "d": cosim.Trapezoid(1.0, 1.0, 1.0)}
    assert cosim.signals_of(given) == given
    with pytest.raises(
        cosim.SignalError, match=r"inputs: expected a dictionary .* data frame, got"
    ):
        cosim.signals_of([1.0])


def test_a_column_that_is_not_there_cannot_be_held():
    with pytest.raises(cosim.SignalError, match="cannot hold x"):
        cosim.read_tables(FRAME, held=["x"])


def test_integers_and_truths_are_numbers(tmp_path):
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "in.parquet"
    columns = {"time": [0, 1], "n": arrow.array([3, 4], arrow.uint8()), "on": [False, True]}
    parquet.write_table(arrow.table(columns), path)
    tables = cosim.read_tables(path)
    times = np.array([0.0, 1.0])
    assert tables["n"].sample(times).tolist() == [3.0, 4.0]
    assert tables["on"].sample(times).tolist() == [0.0, 1.0]


def test_without_pyarrow_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(cosim.SignalError, match=r"pip install 'stickslip\[parquet\]'"):
        cosim.read_tables(tmp_path / "in.parquet")


def test_results_in_parquet_keep_every_bit_and_the_units(make, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    system = cosim.System("one")
    system.add("a", make("gain"))
    system.expose("x", "a.u")
    result = system.prepare(step=0.1, stop=1.0).run(inputs={"x": np.sin})
    path = result.to_parquet(tmp_path / "out.parquet")
    schema = parquet.read_schema(path)
    assert schema.field("a.y").metadata == {b"unit": b"N"}
    assert schema.field("time").metadata == {b"unit": b"s"}
    again = cosim.read_tables(path)
    np.testing.assert_array_equal(again["a.y"].values, result["a.y"])
    assert [p.name for p in tmp_path.iterdir()] == ["out.parquet"]
