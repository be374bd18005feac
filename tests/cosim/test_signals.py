"""Inputs: signals, functions of time, tables from frames and files."""

import math
import sys

import numpy as np
import pandas as pd
import pint
import pint_pandas  # noqa: F401 - it defines the types of columns
import pyarrow
import pytest
from pyarrow import parquet

from stickslip import cosim
from tests.cosim.single import joined, one

T = np.linspace(0.0, 10.0, 10_001)
GRID = np.arange(5) * 0.5  # of the simulation
SQUARES = GRID**2


def test_sine_sweep_runs_from_one_frequency_and_amplitude_to_the_other():
    sweep = cosim.SineSweep(frequency=(0.1, 5.0), amplitude=(0.03, 0.04), duration=10.0)
    v = sweep.sample(T)
    # half the mean frequency times the duration is the number of rising zero crossings
    crossings = np.flatnonzero((v[:-1] < 0) & (v[1:] >= 0))
    assert len(crossings) == int(0.5 * (0.1 + 5.0) * 10.0)
    assert np.diff(T[crossings])[-1] == pytest.approx(1 / 5.0, rel=0.05)
    assert np.abs(v[:3000]).max() < 0.033 < np.abs(v[8000:]).max() <= 0.04
    assert v[0] == 0
    assert sweep.sample(np.array([-1.0, 11.0])).tolist() == [0, 0]


def test_trapezoid_goes_there_and_back():
    v = cosim.Trapezoid(height=0.04, slope=0.08, plateau=1.0, begin=1.0).sample(T)
    assert (v.max(), v.min()) == (0.04, -0.04)
    assert np.sum(v) * 1e-3 == pytest.approx(0.0, abs=1e-9)
    assert np.abs(np.diff(v)).max() / 1e-3 == pytest.approx(0.08)
    assert np.all(v[T <= 1.0] == 0)


@pytest.fixture
def simulation(make):
    system = joined({"a": make("gain")}, force="a.u")
    with system.prepare(step=0.5, stop=2.0) as simulation:
        yield simulation


def test_all_kinds_of_inputs(simulation):
    ramp = np.arange(5) * 0.5
    for signal in (ramp, list(ramp), lambda t: t, cosim.Table([0, 8], [0, 8])):
        np.testing.assert_array_equal(simulation.run(inputs={"force": signal})["force"], ramp)
    assert set(simulation.run(inputs={"force": 3})["force"]) == {3.0}


def moved(t):
    t += 1.0
    return t


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (math.exp, [math.exp(t) for t in (0.0, 0.5, 1.0, 1.5, 2.0)]),
        (lambda t: 12 if t > 0.5 else 0, [0, 0, 12, 12, 12]),
        (lambda t: [t], GRID),
        (lambda t: np.float32(t) > 0.5, [0, 0, 1, 1, 1]),
        (lambda t: SQUARES[np.abs(GRID - t).argmin()], SQUARES),
        (lambda t: np.linalg.norm([3.0 * t, 4.0 * t]), 5.0 * GRID),
        (moved, GRID + 1.0),
    ],
)
def test_a_function_of_one_time_gives_the_value_at_each(simulation, function, expected):
    result = simulation.run(inputs={"force": function})
    np.testing.assert_array_equal(result["force"], expected)
    np.testing.assert_array_equal(result.time, GRID)


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (np.zeros(4), r"shape \(4,\), expected \(5,\)"),
        ([0, 0, np.nan, 0, 0], "not finite at t = 1 s"),
        (lambda t: 1 / (t - 1.0) if t else 0.0, "t = 1 s the function raised ZeroDivisionError"),
        (lambda t: t["a"], "raised TypeError: 'float' .*; for an array of all times .*IndexError"),
        (print, "at t = 0 s the function returned None, expected a number"),
        (lambda t: [t, t], r"the function returned \[0\.0, 0\.0\], expected a number"),
        (lambda t: t * 1j, "expected numbers"),
        (np.ma.masked_greater(GRID, 0.5), "not finite at t = 1 s"),
        ("text", "expected numbers"),
        (pint.Quantity(1.0, "kN"), "in the unit of the input, got a quantity in kilonewton"),
        (pd.Series([1.0, 2.0], [0.0, 1.0], dtype="pint[kN]"), "holds quantities in kilonewton"),
    ],
)
def test_inputs_that_cannot_be(simulation, signal, message):
    with pytest.raises(cosim.SignalError, match=message):
        simulation.run(inputs={"force": signal})


FRAME = pd.DataFrame({"time": [0.0, 1.0, 1.0, 2.0], "v": [0.0, 1.0, 5.0, 6.0], "w": [1, 2, 3, 4]})
AT = np.array([-1.0, 0.5, 1.0, 1.5, 9.0])


@pytest.mark.parametrize("kind", ["frame", "index", "csv", "parquet"])
def test_all_sources_give_the_same_signals(tmp_path, kind):
    source = tmp_path / f"in.{kind}"
    if kind == "csv":
        FRAME.to_csv(source, index=False)
    elif kind == "parquet":
        FRAME.to_parquet(source)
    else:
        source = FRAME.set_index("time") if kind == "index" else FRAME
    tables = cosim.read_tables(source, held=["w"])
    assert tables["v"].sample(AT).tolist() == [0.0, 0.5, 5.0, 5.5, 6.0]
    assert tables["w"].sample(AT).tolist() == [1.0, 1.0, 3.0, 3.0, 4.0]
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
    assert found.sample(AT).tolist() == cosim.Table(time, FRAME["v"]).sample(AT).tolist()


def test_other_inputs_stay_what_they_are():
    given = {"a": 1.0, "b": [0.0, 1.0], "c": np.sin, "d": cosim.Trapezoid(1.0, 1.0, 1.0)}
    assert cosim.signals_of(given) == given
    with pytest.raises(
        cosim.SignalError, match=r"inputs: expected a dictionary .* data frame, got"
    ):
        cosim.signals_of([1.0])


def test_integers_and_truths_are_numbers(tmp_path):
    path = tmp_path / "in.parquet"
    columns = {"time": [0, 1], "n": pyarrow.array([3, 4], pyarrow.uint8()), "on": [False, True]}
    parquet.write_table(pyarrow.table(columns), path)
    tables = cosim.read_tables(path)
    times = np.array([0.0, 1.0])
    assert tables["n"].sample(times).tolist() == [3.0, 4.0]
    assert tables["on"].sample(times).tolist() == [0.0, 1.0]


def test_without_pyarrow_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(cosim.SignalError, match=r"pip install '.*\[parquet\]'"):
        cosim.read_tables(tmp_path / "in.parquet")


def test_results_in_parquet_keep_every_bit_and_the_units(make, tmp_path):
    system = one(make("gain"), u="u")
    result = system.prepare(step=0.1, stop=1.0).run(inputs={"u": np.sin})
    path = result.to_parquet(tmp_path / "out.parquet")
    schema = parquet.read_schema(path)
    assert schema.field("a.y").metadata == {b"unit": b"N"}
    assert schema.field("time").metadata == {b"unit": b"s"}
    again = cosim.read_tables(path)
    np.testing.assert_array_equal(again["a.y"].values, result["a.y"])
    assert [p.name for p in tmp_path.iterdir()] == ["out.parquet"]


def read(tmp_path, data: bytes):
    file = tmp_path / "in.csv"
    file.write_bytes(data)
    return cosim.Table.all_from_csv(file)


@pytest.mark.parametrize(
    "data",
    [
        b"time,u\n0,1\n1,3\n",
        b"\xef\xbb\xbftime,u\r\n0,1\r\n1,3\r\n",
        b'"time" , "u"\n0,1\n\n1,3'.replace(b'" , "', b'","'),
        b"time, u\r 0 , 1.0\r1e0,+3\r",
        b"u,time\n1,0\n3,1\n",
    ],
    ids=["plain", "mark and CRLF", "quoted", "CR and blanks", "time last"],
)
def test_one_table_in_many_forms(tmp_path, data):
    tables = read(tmp_path, data)
    assert list(tables) == ["u"]
    assert tables["u"].time.tolist() == [0.0, 1.0]
    assert tables["u"].sample(np.array([0.0, 1.0])).tolist() == [1.0, 3.0]


def test_one_row_is_a_constant(tmp_path):
    table = read(tmp_path, b"time,u\n5,7\n")["u"]
    assert table.sample(np.array([0.0, 5.0, 9.0])).tolist() == [7.0, 7.0, 7.0]
