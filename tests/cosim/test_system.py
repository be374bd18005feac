"""A system refuses what cannot be, and names both ends and what was meant."""

from __future__ import annotations

import math
import pickle

import pytest

from stickslip import cosim


@pytest.fixture
def system(make):
    system = cosim.System("loop")
    system.add("drive", make("integrator"))
    system.add("controller", make("gain"))
    return system


@pytest.mark.parametrize(
    ("source", "target", "message"),
    [
        ("drive.yy", "controller.u", r"cannot connect drive\.yy to controller\.u.*mean 'y'"),
        ("drove.y", "controller.u", "has no component 'drove'.*mean 'drive'"),
        ("drive.y", "controller.w", "no variable 'w'; there is u, y"),
        ("drive.u", "controller.u", r"drive\.u is a Real input, expected an output"),
        ("drive.y", "controller.k", r"controller\.k is a Real parameter, expected .* input"),
        ("drive.y", "controller.n", r"controller\.n is a Integer parameter"),
        ("drive", "controller.u", "no variable ''"),
    ],
)
def test_impossible_connections(system, source, target, message):
    with pytest.raises(cosim.ConnectionFault, match=message):
        system.connect(source, target)


def test_an_input_has_one_source(system):
    system.connect("drive.y", "controller.u")
    with pytest.raises(cosim.ConnectionFault, match=r"already connected to drive\.y"):
        system.connect("controller.y", "controller.u")
    with pytest.raises(cosim.ConnectionFault, match=r"already connected to drive\.y"):
        system.expose("x", "controller.u")
    system.expose("force", "drive.u")
    with pytest.raises(cosim.ConnectionFault, match="already connected to force"):
        system.connect("controller.y", "drive.u")


def test_units_must_measure_the_same(make):
    system = cosim.System()
    system.add("force", make("gain"))
    system.add("same", make("gain", u="kg.m/s2"))
    system.add("milli", make("gain", u="mN"))
    system.add("length", make("gain", u="m"))
    system.connect("force.y", "same.u")
    with pytest.raises(cosim.ConnectionFault, match=r"force\.y is in 'N', length\.u in 'm'"):
        system.connect("force.y", "length.u")
    with pytest.raises(cosim.ConnectionFault, match=r"'mN'.*'m'"):
        system.expose("both", "milli.u", "length.u")
    assert system.inputs == {}


@pytest.mark.parametrize("name", ["", "a.b"])
def test_names_that_cannot_be(system, make, name):
    with pytest.raises(cosim.ConnectionFault):
        system.add(name, make("gain"))
    with pytest.raises(cosim.ConnectionFault):
        system.expose(name, "drive.u")


def test_a_component_is_added_once(system, make):
    with pytest.raises(cosim.ConnectionFault, match="already has a component 'drive'"):
        system.add("drive", make("gain"))


def test_a_component_with_a_wrong_parameter_is_not_added(system, make):
    with pytest.raises(cosim.ParameterError, match=r"no variable 'kk'; did you mean 'k'"):
        system.add("third", make("gain"), {"kk": 1.0})
    assert "third" not in system.components


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("drive.q", 1.0, "no variable 'q'"),
        ("drove.k", 1.0, "did you mean 'drive'"),
        ("drive.k", 1001.0, r"drive\.k = 1001\.0 is outside its range -1000\.0 to 1000\.0"),
        ("drive.fault_time", math.inf, "outside its range"),
        ("drive.k", math.nan, "outside its range"),
        ("drive.k", "much", "expected a value of type Real, got 'much'"),
        ("drive.n", 1.5, "expected a value of type Integer"),
        ("drive.n", 10, "outside its range"),
        ("drive.fault", 2**31, "expected a value of type Integer"),
        ("drive.flag", 2, "expected a value of type Boolean"),
        ("drive.text", 2, "expected a value of type String"),
        ("drive.y", 1.0, "cannot be set: it is a continuous output"),
    ],
)
def test_start_values_that_cannot_be(system, name, value, message):
    with pytest.raises(cosim.ParameterError, match=message):
        system.set(name, value)


def test_pickles(system):
    system.connect("drive.y", "controller.u")
    system.expose("force", "drive.u")
    system.set("drive.k", 2.0)
    twin = pickle.loads(pickle.dumps(system))  # noqa: S301 - our own bytes
    assert (twin.connections, twin.inputs) == (system.connections, system.inputs)
    assert twin.parameters == {"drive.k": 2.0}


def test_an_algebraic_loop_is_named(make):
    system = cosim.System()
    for name in "abc":
        system.add(name, make("gain"))
    system.connect("a.y", "b.u")
    system.connect("b.y", "c.u")
    system.connect("c.y", "a.u")
    with pytest.raises(cosim.ConnectionFault) as error:
        system.prepare(step=0.1, stop=1.0)
    loop = str(error.value).removeprefix("algebraic loop ").partition(":")[0].split(" -> ")
    assert len(loop) == 6
    assert set(loop) == {"a.y", "b.u", "b.y", "c.u", "c.y", "a.u"}
    for source, target in zip(loop[::2], loop[1::2], strict=True):
        assert system.connections[target] == source
    assert "coupling='jacobi'" in str(error.value)
    system.prepare(step=0.1, stop=1.0, coupling="jacobi").run()
