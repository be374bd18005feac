from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from stickslip import cosim


@pytest.fixture
def result(make):
    system = cosim.System()
    system.add("a", make("integrator"))
    system.expose("force", "a.u")
    with system.prepare(step=0.1, stop=1.0, record=["force", "a.y", "a.k"]) as simulation:
        return simulation.run(inputs={"force": lambda t: np.sin(t) / 3})


def test_names_units_and_frame(result):
    assert tuple(result) == result.names == ("force", "a.y", "a.k")
    assert result.units == {"force": "N", "a.y": "N", "a.k": None}
    frame = result.frame()
    assert frame.index.name == "time"
    assert frame.attrs["units"] == result.units
    np.testing.assert_array_equal(frame["a.y"], result["a.y"])


def test_csv_keeps_every_digit(result, tmp_path):
    read = pd.read_csv(result.to_csv(tmp_path / "out.csv"))
    assert list(read) == ["time", "force", "a.y", "a.k"]
    np.testing.assert_array_equal(read["time"], result.time)
    np.testing.assert_array_equal(read["a.y"], result["a.y"])


@pytest.mark.parametrize(
    ("record", "kept"), [({"every": 4}, slice(None, None, 4)), ({"keep": "last"}, slice(-1, None))]
)
def test_tables_of_a_part(make, tmp_path, record, kept):
    system = cosim.System()
    system.add("a", make("integrator"), {"u": 1.0})
    full = system.prepare(step=0.1, stop=1.0).run()
    part = system.prepare(step=0.1, stop=1.0, record=cosim.Record("a.y", **record)).run()
    read = pd.read_csv(part.to_csv(tmp_path / "out.csv"))
    np.testing.assert_array_equal(read["time"], full.time[kept])
    np.testing.assert_array_equal(read["a.y"], full["a.y"][kept])
    read = pd.read_parquet(part.to_parquet(tmp_path / "out.parquet"))
    np.testing.assert_array_equal(read["a.y"], part["a.y"])
    assert part.frame().attrs["units"] == {"a.y": "N"}


def test_what_was_not_recorded_is_named(result):
    with pytest.raises(KeyError, match=r"'a\.x' was not recorded; did you mean"):
        result["a.x"]
    assert "a.y" in result
    assert "a.x" not in result
