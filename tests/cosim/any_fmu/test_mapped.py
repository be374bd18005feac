"""Pairs of values on connections: whatever is no floating-point number can be mapped."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Coupling, Link, ValueMap
from tests.cosim.single import one, saves

COUPLINGS = ["gauss_seidel", "jacobi", Coupling(degree=1), Coupling("iterative")]
FLIP = Link(ValueMap.of({0: 1, 1: 0}))


def chain(export, version, source, target, link, flags=""):
    system = cosim.System()
    path = export("feedthrough", version, flags=flags)
    for name in ("a", "b"):
        system.add(name, path, interface="co_simulation")
    system.connect(f"a.{source}_out", f"b.{target}_in", link)
    system.expose("u", f"a.{source}_in")
    return system


def seen(system, values, coupling="gauss_seidel", **how):
    with system.prepare(step=0.1, stop=0.1 * (len(values) - 1), coupling=coupling, **how) as run:
        return run.run(inputs={"u": np.asarray(values, float)})


@pytest.mark.parametrize("coupling", COUPLINGS, ids=str)
def test_what_has_a_pair_is_replaced_and_all_else_stays(export, version, coupling):
    link = Link(ValueMap.of({1: 20, 2: 30}))
    system = chain(export, version, "Int32", "Int32", link, saves(version))
    result = seen(system, [0, 1, 2, 3, 2, 1, 0, 0], coupling)
    mapped = np.vectorize({0: 0, 1: 20, 2: 30, 3: 3}.get)(result["a.Int32_out"])
    delay = 1 if coupling == "jacobi" else 0
    np.testing.assert_array_equal(
        result["b.Int32_out"][1:], np.append(np.zeros(delay), mapped[1 : len(mapped) - delay])
    )


def test_an_exposed_input_is_mapped_and_starts_with_what_leads_to_the_start_value(export):
    system = one(export("feedthrough", 3), {"Int8_in": 7}, interface="co_simulation")
    system.expose("u", "a.Int8_in", links={"a.Int8_in": Link(ValueMap.of({3: 7}))})
    with system.prepare(step=0.1, stop=0.2) as simulation:
        assert set(simulation.run()["u"]) == {3.0}
        assert set(simulation.run(inputs={"u": 3})["a.Int8_out"]) == {7.0}


def test_compiled_steps_give_the_same(export):
    system = chain(export, 3, "Boolean", "Boolean", FLIP)
    one, other = (seen(system, [0, 1, 0, 0], compiled=how).values for how in (False, True))
    np.testing.assert_array_equal(one, other)


def test_maps_follow_each_other():
    one, two = ValueMap.of({1: 2, 5: 6}), ValueMap.of({2: 3, 9: 8})
    both = one.then(two)
    assert [both(x) for x in (1, 2, 5, 9, 4)] == [two(one(x)) for x in (1, 2, 5, 9, 4)]
    assert one.then(cosim.Scaling()) == cosim.Scaling().then(one) == one
    for a, b in ((one, cosim.Scaling(2.0)), (cosim.Scaling(2.0), one)):
        with pytest.raises(TypeError):
            a.then(b)


@pytest.mark.parametrize(
    ("source", "target", "pairs", "message"),
    [
        ("Float64", "Float32", {}, "Float64_out is a Float64, .* need an integer, Boolean"),
        ("Int32", "UInt8", {1: 256}, r"b\.UInt8_in: expected a value of type UInt8, got 256"),
        ("Int32", "Boolean", {1: 2}, "expected a value of type Boolean, got 2"),
    ],
)
def test_pairs_that_do_not_fit_are_refused(export, source, target, pairs, message):
    with pytest.raises(cosim.ConnectionFault, match=message):
        chain(export, 3, source, target, Link(ValueMap.of(pairs)))


@pytest.mark.parametrize(
    ("version", "source", "target", "values"),
    [
        (2, "Boolean", "Float64", [0, 1, 1, 0]),
        (3, "Boolean", "Float64", [0, 1, 1, 0]),
        (2, "Boolean", "Int32", [0, 1, 1, 0]),
        (2, "Int32", "Float64", [-(2**31), 3, 0, 2**31 - 1]),
        (2, "Int32", "Enumeration", [1, 3, 2, 1]),
        (3, "Enumeration", "UInt8", [1, 3, 2, 1]),
        (3, "Float32", "Float64", [0.5, 0.25, -1.0, 2.0]),
        (3, "UInt8", "Int64", [0, 255, 7, 1]),
    ],
)
@pytest.mark.parametrize("coupling", COUPLINGS, ids=str)
def test_types_that_lose_nothing_connect_as_they_are(
    export, version, coupling, source, target, values
):
    system = chain(export, version, source, target, Link(), saves(version))
    result = seen(system, values, coupling)
    given, delay = result[f"a.{source}_out"], int(coupling == "jacobi")
    assert set(given[1:]) <= set(values)
    np.testing.assert_array_equal(result[f"b.{target}_out"][1 + delay :], given[1 : 4 - delay])


@pytest.mark.parametrize(
    ("source", "target", "values", "expected"),
    [
        ("Float64", "Int32", [0.0, 2.9, -2.9, 1e300], [2, -2, 2**31 - 1]),
        ("Float64", "Boolean", [0.0, 0.25, 0.0, -3.0], [1, 0, 1]),
        ("Int32", "Boolean", [0, 2, 0, -1], [1, 0, 1]),
    ],
)
def test_what_loses_a_part_of_the_value_is_asked_for_by_pairs(
    export, source, target, values, expected
):
    with pytest.raises(cosim.ConnectionFault, match=r"loses a part of the value; give pairs"):
        chain(export, 3, source, target, Link())
    system = chain(export, 3, source, target, Link(ValueMap.of({})))
    result = seen(system, [*values[1:], 0.0])
    np.testing.assert_array_equal(result[f"b.{target}_out"][1:], expected)
