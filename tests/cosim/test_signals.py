from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pint
import pint_pandas  # noqa: F401 - it defines the types of columns
import pytest

from stickslip import cosim

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


def test_table_from_csv(tmp_path):
    path = tmp_path / "in.csv"
    path.write_text("\ufefftime,v,w\r\n0,1,10\r\n\r\n1,2,20\r\n", encoding="utf-8")
    assert cosim.Table.from_csv(path, "w").sample(np.array([0.5])) == [15.0]
    assert set(cosim.Table.all_from_csv(path)) == {"v", "w"}
    with pytest.raises(cosim.SignalError, match="no column"):
        cosim.Table.from_csv(path)


@pytest.fixture
def simulation(make):
    system = cosim.System("loop")
    system.add("a", make("gain"))
    system.expose("force", "a.u")
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
        (1j, "expected numbers, got 1j"),
        (np.ma.masked_greater(GRID, 0.5), "not finite at t = 1 s"),
        ("text", "expected numbers"),
        ("12", "expected numbers"),
        (pint.Quantity(1.0, "kN"), "in the unit of the input, got a quantity in kilonewton"),
        (pd.Series([1.0, 2.0], [0.0, 1.0], dtype="pint[kN]"), "holds quantities in kilonewton"),
    ],
)
def test_inputs_that_cannot_be(simulation, signal, message):
    with pytest.raises(cosim.SignalError, match=message):
        simulation.run(inputs={"force": signal})


def test_an_input_that_is_not_exposed(simulation):
    with pytest.raises(cosim.SignalError, match="no exposed input 'fours'; did you mean 'force'"):
        simulation.run(inputs={"fours": 1.0})
