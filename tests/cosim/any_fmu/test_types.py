"""All types of FMI 3.0 as signals and start values, and arrays of them."""

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.any_fmu.conftest import NUMERIC
from tests.cosim.single import by_fmpy, joined, one

TYPES = {2: ["Float64", "Int32", "Boolean", "Enumeration"], 3: NUMERIC}
CASES = [(version, name) for version in TYPES for name in [*TYPES[version], "discrete"]]


@pytest.mark.parametrize(("version", "name"), CASES)
def test_a_connection_carries_any_type(export, version, name):
    parts = dict.fromkeys("ab", export("feedthrough", version))
    system = joined(parts, f"a.{name}_out b.{name}_in", u=f"a.{name}_in")
    with system.prepare(step=0.1, stop=0.5, coupling="jacobi") as simulation:
        result = simulation.run(inputs={"u": np.array([0, 1, 1, 0, 1, 0])})
    np.testing.assert_array_equal(result[f"a.{name}_out"], [0, 0, 1, 1, 0, 1])
    np.testing.assert_array_equal(result[f"b.{name}_out"], [0, 0, 0, 1, 1, 0])


@pytest.mark.parametrize("recorded", ["a.Float64_out", "a.*"])  # as it is, on the general path
def test_a_start_value_of_an_input_is_set_in_initialization_mode(export, version, recorded):
    system = one(export("feedthrough", version), {"Float64_in": 3.0})  # it fails before
    with system.prepare(step=0.1, stop=0.2, record=[recorded]) as simulation:
        np.testing.assert_array_equal(simulation.run()["a.Float64_out"], 3.0)


def test_start_values_of_every_type_arrive_to_the_bit(export):
    system = one(export("feedthrough", 3), {"s": "abc", "bytes": b"\0\1\2\0", "big": 2**62 + 5})
    system.set("a.UInt8_in", 200)
    system.set("a.Boolean_in", True)
    result = system.prepare(step=0.1, stop=0.1).run({"a.Enumeration_in": 3})
    assert result["a.sum"][0] == 3 + 400 + (2**62 + 5) % 1000003
    assert result["a.UInt8_out"][0] == 200
    assert result["a.Boolean_out"][0] == 1
    assert result["a.Enumeration_out"][0] == 3


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("Int32_in", "3.0", 3),
        ("big", str(2**62 + 5), 2**62 + 5),
        ("Boolean_in", "on", True),
        ("s", "1.5", "1.5"),
        ("bytes", "00ff", b"\x00\xff"),
    ],
)
def test_text_is_read_as_the_type_of_the_variable(export, name, text, value):
    system = one(export("feedthrough", 3))
    system.set(f"a.{name}", text)
    assert system.parameters[f"a.{name}"] == value
    for wrong, other in (("UInt8", 256), ("Int8", -129), ("Int64", 2**63)):
        with pytest.raises(cosim.ParameterError, match=f"a.{wrong}_in"):
            system.set(f"a.{wrong}_in", other)


def test_an_alias_is_another_name(export):
    system = one(export("ball", 3), name="ball")
    assert "ball.height of the ball" not in system.prepare(step=0.1, stop=1.0).run()
    with system.prepare(
        step=0.1, stop=1.0, record=["ball.height of the ball", "ball.height"]
    ) as simulation:
        result = simulation.run()
    np.testing.assert_array_equal(result["ball.height of the ball"], result["ball.height"])


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("Int32", 2.9, "whole numbers from -2147483648 to 2147483647"),
        ("Int32", 3e9, "is 3e+09 at t = 0.3 s"),
        ("UInt8", -1.0, "from 0 to 255"),
        ("Boolean", 0.4, "from 0 to 1, because Boolean_in is of type Boolean"),
    ],
)
def test_an_input_that_its_type_cannot_hold_is_refused(export, name, value, expected):
    system = one(export("feedthrough", 3), u=f"{name}_in")
    with system.prepare(step=0.1, stop=0.5) as simulation:
        with pytest.raises(cosim.SignalError, match=expected.replace("+", r"\+")):
            simulation.run(inputs={"u": np.array([0, 1, 0, value, 1, 0])})
        assert simulation.run(inputs={"u": 1.0})[f"a.{name}_out"][-1] == 1.0


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


@pytest.mark.parametrize("n", [1, 2, 5])
def test_structural_parameters_set_the_dimensions(export, n):
    fmu = export("state_space", 3, "CS")
    first = fmu, {"n": n, "A": -np.eye(n), "x0": np.arange(1.0, n + 1)}
    system = joined({"a": first, "b": (fmu, {"n": n, "A": np.zeros((n, n))})}, "a.y b.u")
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


@pytest.mark.parametrize(
    ("fmu", "wires", "it"),
    [
        (("feedthrough", 3, "CS"), ["a.Int32_out b.Int32_in"], "needs Model"),
        (("feedthrough", 3, "ME"), ["a.Float64_out b.Float64_in"], "needs Model"),
        (("state_space", 3, "CS"), [], "has the struct"),
    ],
)
def test_what_a_container_cannot_hold(export, tmp_path, fmu, wires, it):
    system = joined(dict.fromkeys("ab", export(*fmu)), *wires)
    with pytest.raises(cosim.FmuError, match=rf"a \(.*cannot go into a container: it {it}"):
        cosim.write_fmu(system, tmp_path / "a.fmu", step=0.1)


def test_a_container_shows_outputs_that_are_doubles(export, tmp_path):
    system = one(export("feedthrough", 2, "CS"))
    shown = cosim.Fmu(cosim.write_fmu(system, tmp_path / "a.fmu", step=0.1)).variables
    assert "a.Float64_out" in shown
    assert {v.type for v in shown.values() if v.causality == "output"} == {"Real"}
