from __future__ import annotations

import numpy as np
import pytest

import cosim
from cosim.scaling import IDENTITY, PLAIN, Link, Scaling
from cosim.units import Unit

NEWTON = Unit("N", (1, 1, -2, 0, 0, 0, 0, 0))
KELVIN = Unit("K", (0, 0, 0, 0, 1, 0, 0, 0))
CELSIUS = Unit("degC", KELVIN.exponents, 1.0, 273.15)
FAHRENHEIT = Unit("degF", KELVIN.exponents, 5 / 9, 273.15 - 32 * 5 / 9)


def two_gains(make, source, target, link=PLAIN):
    system = cosim.System("line")
    system.add("a", make("gain", y=source), {"k": 2.0})
    system.add("b", make("gain", 3, u=target))
    system.expose("x", "a.u")
    system.connect("a.y", "b.u", link)
    return system


def end(system, **inputs):
    with system.prepare(step=0.5, stop=1.0) as simulation:
        return simulation.run(inputs=inputs)["b.y"][-1]


def test_a_unit_converts_to_itself_and_back():
    assert NEWTON.to(NEWTON) == IDENTITY
    there, back = FAHRENHEIT.to(CELSIUS), CELSIUS.to(FAHRENHEIT)
    assert there(212.0) == pytest.approx(100.0)
    assert there.then(back)(50.0) == pytest.approx(50.0)
    assert there.inverse(there(50.0)) == pytest.approx(50.0)
    assert NEWTON.to(KELVIN) is None


@pytest.mark.parametrize(("source", "target", "factor"), [("mN", "N", 1e-3), ("N", "mN", 1e3)])
def test_a_connection_converts_units(make, source, target, factor):
    assert end(two_gains(make, source, target), x=3.0) == pytest.approx(6.0 * factor, rel=1e-15)


def test_an_exposed_input_has_one_unit_and_feeds_targets_in_theirs(make):
    system = cosim.System("fan")
    system.add("a", make("gain"))
    system.add("b", make("gain", u="mN"))
    system.expose("x", "a.u", "b.u")
    assert end(system, x=2.0) == pytest.approx(2000.0)
    other = cosim.System("fan")
    other.add("b", make("gain", u="mN"), {"u": 7000.0})
    other.expose("x", "b.u", unit=NEWTON)
    assert other.unit("x") == "N"
    assert end(other) == pytest.approx(7000.0)  # the start value of the target, through its unit


def test_units_of_different_kinds_are_refused_with_both_ends(make):
    with pytest.raises(cosim.ConnectionFault, match=r"a\.y is in 'm', b\.u in 'N'"):
        two_gains(make, "m", "N")


def test_a_scaling_comes_after_the_units_or_in_their_place(make):
    line = Scaling(factor=10.0, offset=1.0)
    assert end(two_gains(make, "mN", "N", Link(line)), x=3.0) == pytest.approx(0.06 + 1)
    assert end(two_gains(make, "mN", "N", Link(line, convert=False)), x=3.0) == 61.0
    assert end(two_gains(make, "m", "N", Link(convert=False)), x=3.0) == 6.0


def test_a_scaling_of_one_changes_no_bit(make):
    signal = np.array([0.1, -0.3, 0.7])
    plain = two_gains(make, "N", "N")
    assert end(plain, x=signal) == end(two_gains(make, "N", "kg.m/s2"), x=signal)
