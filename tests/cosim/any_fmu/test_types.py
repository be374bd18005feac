"""Every numeric type goes in, out and across a connection; every type can be a start value."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import by_fmpy, one

ALL = ["Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64"]
ALL += ["UInt64", "Boolean", "Enumeration", "discrete"]
TYPES = {2: ["Float64", "Int32", "Boolean", "Enumeration", "discrete"], 3: ALL}
CASES = [(version, name) for version, names in TYPES.items() for name in names]


@pytest.mark.parametrize(("version", "name"), CASES)
def test_a_signal_of_any_type_equals_fmpy(export, version, name):
    path = export("feedthrough", version)
    time = np.array([0.0, 0.2, 0.5, 0.8, 1.0])
    values = np.array([0, 1, 1, 0, 1])
    system = one(path)
    system.expose("u", f"a.{name}_in")
    ours = system.prepare(step=0.1, stop=1.0).run(inputs={"u": cosim.Table(time, values)})
    kind = {"Float64": "f8", "Float32": "f4", "discrete": "f8", "Boolean": "?"}.get(name, "i8")
    signals = [time, (f"{name}_in", kind, values)]
    theirs = by_fmpy(path, 0.1, 1.0, f"{name}_out", inputs=signals, step_size=0.1)
    np.testing.assert_array_equal(ours[f"a.{name}_out"], theirs[f"{name}_out"].astype(float))


@pytest.mark.parametrize(("version", "name"), CASES)
def test_a_connection_carries_any_type(export, version, name):
    system = one(export("feedthrough", version))
    system.add("b", export("feedthrough", version), interface="co_simulation")
    system.connect(f"a.{name}_out", f"b.{name}_in")
    system.expose("u", f"a.{name}_in")
    with system.prepare(step=0.1, stop=0.5, coupling="jacobi") as simulation:
        result = simulation.run(inputs={"u": np.array([0, 1, 1, 0, 1, 0])})
    np.testing.assert_array_equal(result[f"a.{name}_out"], [0, 0, 1, 1, 0, 1])
    np.testing.assert_array_equal(result[f"b.{name}_out"], [0, 0, 0, 1, 1, 0])


def test_only_equal_types_connect(export):
    system = one(export("feedthrough", 3))
    system.add("b", export("feedthrough", 2))
    system.connect("a.Float64_out", "b.Float64_in")
    system.connect("a.Int32_out", "b.Int32_in")
    with pytest.raises(cosim.ConnectionFault, match=r"a\.Int16_out is a Int16, b\.Boolean_in a B"):
        system.connect("a.Int16_out", "b.Boolean_in")


def test_a_number_beyond_the_type_of_a_connected_input_is_held_at_its_end(export):
    system = one(export("feedthrough", 3), u="Int64_in")
    system.add("b", export("feedthrough", 3), interface="co_simulation")
    system.connect("a.Int64_out", "b.Int32_in")
    with system.prepare(step=0.1, stop=0.2, coupling="gauss_seidel") as simulation:
        result = simulation.run(inputs={"u": np.array([2.0**40, -(2.0**40), 0.0])})
    np.testing.assert_array_equal(result["b.Int32_out"][1:], [2**31 - 1, -(2**31)])


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("recorded", ["a.Float64_out", "a.*"])  # as it is, on the general path
def test_a_start_value_of_an_input_is_set_in_initialization_mode(export, version, recorded):
    system = cosim.System()
    system.add("a", export("feedthrough", version), {"Float64_in": 3.0})  # it fails before
    with system.prepare(step=0.1, stop=0.2, record=[recorded]) as simulation:
        np.testing.assert_array_equal(simulation.run()["a.Float64_out"], 3.0)


def test_the_ends_of_64_bits_are_reached(export):
    ends = {"Int64": [-(2**63), 2**63 - 1], "UInt64": [0, 2**64 - 1]}
    path = export("feedthrough", 3)
    system = one(path)
    for name in ends:
        system.expose(name, f"a.{name}_in")
    with system.prepare(step=0.5, stop=2.0) as simulation:
        ours = simulation.run(inputs={n: cosim.Table([0.0, 1.0], x) for n, x in ends.items()})
    kinds = {"Int64": "i8", "UInt64": "u8"}
    signals = [(f"{name}_in", kinds[name], values) for name, values in ends.items()]
    outputs = [f"{name}_out" for name in ends]
    theirs = by_fmpy(path, 0.5, 2.0, *outputs, inputs=[[0.0, 1.0], *signals])
    for name in ends:
        np.testing.assert_array_equal(ours[f"a.{name}_out"], theirs[f"{name}_out"].astype(float))


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


@pytest.mark.parametrize(
    ("name", "value"),
    [("UInt8_in", 256), ("Int8_in", -129), ("Int64_in", 2**63), ("Int32_in", 0.5), ("bytes", 3)],
)
def test_a_start_value_that_a_type_cannot_hold_is_refused(export, name, value):
    system = one(export("feedthrough", 3))
    with pytest.raises(cosim.ParameterError, match=f"a.{name}"):
        system.set(f"a.{name}", value)


def test_an_alias_is_another_name(export):
    system = cosim.System()
    system.add("ball", export("ball", 3))
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
    system = one(export("feedthrough", 3))
    system.expose("u", f"a.{name}_in")
    with system.prepare(step=0.1, stop=0.5) as simulation:
        with pytest.raises(cosim.SignalError, match=expected.replace("+", r"\+")):
            simulation.run(inputs={"u": np.array([0, 1, 0, value, 1, 0])})
        assert simulation.run(inputs={"u": 1.0})[f"a.{name}_out"][-1] == 1.0
