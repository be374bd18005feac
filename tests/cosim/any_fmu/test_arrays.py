"""Arrays of FMI 3.0: whole as start values, by element as signals, sized by parameters."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cli import main
from tests.cosim.single import by_fmpy, one

MATRIX = np.array([[-1.0, 0.5, 0.0], [0.0, -2.0, 1.0], [0.3, 0.0, -0.5]])


def system_of(export, parameters):
    return one(export("state_space", 3, "CS"), parameters)


def test_arrays_as_start_values_equal_fmpy(export):
    x0 = [1.0, 2.0, 3.0]
    system = system_of(export, {"A": MATRIX, "x0": x0, "u": (0.1, 0.2, 0.3)})
    ours = system.prepare(step=0.125, stop=2.0).run()
    starts = {"A": MATRIX.reshape(-1), "x0": x0, "u": [0.1, 0.2, 0.3]}
    path = export("state_space", 3, "CS")
    theirs = by_fmpy(path, 0.125, 2.0, "y", step_size=0.125, start_values=starts)
    assert ours.names == ("a.y[1]", "a.y[2]", "a.y[3]")
    np.testing.assert_array_equal(ours["a.y"], theirs["y"])


def test_one_element_at_a_time_is_the_whole_array(export):
    whole = system_of(export, {"A": MATRIX, "x0": np.ones(3)}).prepare(step=0.1, stop=1.0).run()
    parts = {f"A[{i + 1},{j + 1}]": x for (i, j), x in np.ndenumerate(MATRIX)}
    parts |= {f"x0[{i}]": 1.0 for i in (1, 2, 3)}
    elements = system_of(export, parts).prepare(step=0.1, stop=1.0).run()
    np.testing.assert_array_equal(elements.values, whole.values)


def test_elements_that_are_not_fed_keep_their_start_values(export):
    system = system_of(export, {"u": [1.0, 2.0, 3.0]})
    constant = system.prepare(step=0.1, stop=1.0).run()
    system.expose("u", "a.u[2]")
    fed = system.prepare(step=0.1, stop=1.0).run(inputs={"u": 2.0})
    np.testing.assert_array_equal(fed["a.y"], constant["a.y"])


def test_exposed_elements_start_as_the_array_was_set(export):
    system = system_of(export, {"u": [1.0, 2.0, 3.0]})
    constant = system.prepare(step=0.1, stop=1.0).run()
    for i in (1, 2, 3):
        system.expose(f"u{i}", f"a.u[{i}]")
    np.testing.assert_array_equal(system.prepare(step=0.1, stop=1.0).run()["a.y"], constant["a.y"])
    system.set("a.u[2]", 5.0)
    assert system.prepare(step=0.1, stop=1.0).run()["u2"][0] == 5.0


@pytest.mark.parametrize("n", [1, 2, 5])
def test_structural_parameters_set_the_dimensions(export, n):
    system = system_of(export, {"n": n, "A": -np.eye(n), "x0": np.arange(1.0, n + 1)})
    system.add("b", export("state_space", 3, "CS"), {"n": n, "A": np.zeros((n, n))})
    system.connect("a.y", "b.u")
    result = system.prepare(step=0.015625, stop=1.0).run()
    assert result["a.y"].shape == (65, n)
    decay = (1 - 0.015625) ** np.arange(65)[:, None]
    np.testing.assert_allclose(result["a.y"], decay * np.arange(1, n + 1), rtol=1e-12)
    np.testing.assert_allclose(result["b.y"][-1], np.arange(1, n + 1) * 0.63, rtol=0.02)


def test_dimensions_do_not_change_from_run_to_run(export):
    simulation = system_of(export, {"n": 2}).prepare(step=0.1, stop=1.0)
    simulation.run({"a.n": 2})
    with pytest.raises(cosim.ParameterError, match=r"a\.n = 3 would change the dimensions"):
        simulation.run({"a.n": 3})


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"A": np.eye(2)}, r"a\.A: expected an array of the dimensions \(3, 3\), got \(2, 2\)"),
        ({"x0": 1.0}, r"a\.x0: expected an array"),
        ({"A[4,1]": 1.0}, r"has no variable 'A\[4,1\]'"),
        ({"A[1]": 1.0}, r"has no variable 'A\[1\]'"),
        ({"x0": ["a", "b", "c"]}, r"a\.x0: expected a value of type Float64"),
    ],
)
def test_what_does_not_fit_is_refused(export, parameters, message):
    with pytest.raises(cosim.ParameterError, match=message):
        system_of(export, parameters)


def test_a_container_holds_no_arrays_of_changing_size(export, tmp_path):
    with pytest.raises(cosim.FmuError, match="cannot go into a container: it has the struct"):
        cosim.write_fmu(system_of(export, None), tmp_path / "a.fmu", step=0.1)


def test_an_array_is_an_input_from_one_column(export, tmp_path, capsys):
    """Numbers of a cell are elements row by row, as if each had a column of its own."""
    path = export("state_space", 3, "CS")
    rows = ["time,u", "0,0.1 0.2 0.3", "1,1 2 3", "2,-1 0 1"]
    (tmp_path / "one.csv").write_text("\n".join(rows))
    apart = [row.replace(" ", ",") for row in rows]
    apart[0] = 'time,"u[1]","u[2]","u[3]"'
    (tmp_path / "three.csv").write_text("\n".join(apart))
    results = []
    for name in ("one", "three"):
        out = tmp_path / f"{name}-out.csv"
        arguments = ["--stop", "2", "--step", "0.1", "--input", str(tmp_path / f"{name}.csv")]
        assert main(["simulate", str(path), *arguments, "--out", str(out)]) == 0
        results.append(out.read_text())
    assert results[0] == results[1]
    assert "inputs that stay" not in capsys.readouterr().err
