"""A system in one FMU does what the system does, in other tools too."""

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from stickslip import cosim
from stickslip.fmi import toolchain
from tests.cosim.single import by_fmpy, joined, members, one, repacked

STEP, STOP = 0.01, 1.0
ARM = toolchain.PLATFORMS["aarch64-linux"]


@pytest.fixture
def loop(make):
    """A controller and an integrator of both versions of FMI, with a unit converted between."""
    parts = {
        "plant": (make("integrator", 3), {"k": 0.0}),
        "feedback": (make("gain", 2, y="mN"), {"k": -3.0}),
        "limit": (make("gain", 3), {"n": 4}),
    }
    wires = "plant.y feedback.u", "feedback.y limit.u"
    return joined(parts, *wires, name="a loop", disturbance="plant.u")


@pytest.fixture
def packed(loop, version, tmp_path):
    return cosim.write_fmu(loop, tmp_path / "a.fmu", step=STEP, fmi=version)


def in_fmpy(path, **start_values):
    return by_fmpy(path, STEP, STOP, step_size=STEP, start_values=start_values)


def alone(system, coupling="gauss_seidel", parameters=None, **inputs):
    return system.prepare(step=STEP, stop=STOP, coupling=coupling).run(parameters, inputs)


@pytest.mark.parametrize(
    ("version", "coupling"), [(2, "gauss_seidel"), (3, "gauss_seidel"), (3, "jacobi")]
)
def test_equals_the_system_bit_for_bit(loop, version, coupling, tmp_path):
    path = cosim.write_fmu(loop, tmp_path / "a.fmu", step=STEP, fmi=version, coupling=coupling)
    ours = alone(loop, coupling, {"feedback.k": 5.0}, disturbance=2.0)
    theirs = in_fmpy(path, **{"feedback.k": 5.0, "disturbance": 2.0})
    assert set(theirs.dtype.names) == {"time", *ours} - {"disturbance"}
    for name in theirs.dtype.names[1:]:
        np.testing.assert_array_equal(theirs[name], ours[name])
    assert ours["limit.y"][-1] == pytest.approx(2.0 * STOP * 5.0 * 1e-3, rel=0.02)


def test_steps_at_times_where_rounding_shows(loop, packed):
    """From a Unix time on, the distance of two points is the step but for some 1e-7 s."""
    start = 1.7e9
    how = {"start": start, "step": STEP, "stop": start + 100 * STEP}
    outer = one(packed, {"disturbance": 1.5}).prepare(**how).run()["a.limit.y"]
    inner = loop.prepare(**how).run(inputs={"disturbance": 1.5})["limit.y"]
    np.testing.assert_allclose(outer, inner, rtol=1e-3)
    assert inner[-1] != 0.0


def test_shows_what_is_chosen(loop, tmp_path):
    path = cosim.write_fmu(
        loop, tmp_path / "a.fmu", step=STEP, outputs=["plant.*"], parameters=["*.k"]
    )
    shown = fmpy.read_model_description(path).modelVariables
    assert {v.name for v in shown} - {"time"} == {
        *("disturbance", "plant.y", "plant.sum"),
        *("plant.k", "feedback.k", "limit.k"),
    }
    assert {v.name: v.unit for v in shown}["plant.y"] == "N"
    assert {v.name: v.start for v in shown}["feedback.k"] == "-3.0"


def test_a_difference_is_one_outside_too(make, version, tmp_path):
    system = joined({"a": make("gain", u="K", y="degC difference")}, x="a.u")
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP, fmi=version)
    shown = cosim.Fmu(path).variables
    assert [shown[name].relative for name in ("x", "a.y")] == [False, True]


def test_nothing_is_found_by_validation_and_two_builds_are_the_same(loop, version, tmp_path):
    first, other = (
        cosim.write_fmu(loop, tmp_path / name / "a.fmu", step=STEP, fmi=version) for name in "ab"
    )
    assert not validate_fmu(str(first))
    assert first.read_bytes() == other.read_bytes()
    content = members(first)
    page = content["documentation/index.html"].decode()
    licence = content["documentation/licenses/license.txt"].decode()
    assert "plant (integrator): not stated" in licence
    for text in ("<h1>a loop</h1>", "0.01 s", "<td>plant.y</td><td>feedback.u</td>", "FMI 3.0"):
        assert text in page


def test_lies_in_a_system_twice_and_in_itself(loop, tmp_path):
    inner = cosim.write_fmu(loop, tmp_path / "inner.fmu", step=STEP, fmi=2)
    targets = {name: f"{name}.disturbance" for name in ("one", "two")}
    outer = joined(dict.fromkeys(targets, inner), **targets)
    ours = {value: alone(loop, disturbance=value)["limit.y"] for value in (1.0, 2.0)}
    both = alone(outer, one=1.0, two=2.0)
    np.testing.assert_array_equal(both["one.limit.y"], ours[1.0])
    np.testing.assert_array_equal(both["two.limit.y"], ours[2.0])
    nested = cosim.write_fmu(outer, tmp_path / "outer.fmu", step=STEP, fmi=3)
    result = in_fmpy(nested, one=1.0, two=2.0)
    np.testing.assert_array_equal(result["two.limit.y"], ours[2.0])


def test_runs_again_with_other_values(packed):
    with one(packed).prepare(step=STEP, stop=STOP) as simulation:
        first, changed, again = (
            simulation.run(values)["a.plant.y"]
            for values in ({"a.disturbance": 1.0}, {"a.plant.k": 3.0}, {"a.disturbance": 1.0})
        )
    np.testing.assert_array_equal(first, again)
    assert first[-1] == pytest.approx(STOP)
    np.testing.assert_array_equal(changed, 3.0)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"a.limit.fault": 3, "a.limit.fault_time": 0.5}, "limit: fmi3DoStep failed (status 3)"),
        ({"a.feedback.fault": 3, "a.feedback.fault_time": 0.5}, "feedback: fmi2DoStep failed"),
    ],
)
def test_says_which_component_failed(packed, values, message):
    with one(packed).prepare(step=STEP, stop=STOP) as simulation:
        with pytest.raises(cosim.SimulationError) as caught:
            simulation.run(values)
        assert message in str(caught.value)
        assert "at t = 0.5 s" in str(caught.value)
        simulation.run()  # and goes on


def test_takes_any_communication_step(make, tmp_path):
    """y' = -3 y with inputs of the step before, by the steps into which each is divided."""
    parts = {"plant": (make("integrator", 3), {"k": 1.0}), "feedback": (make("gain"), {"k": -3.0})}
    system = joined(parts, "plant.y feedback.u", "feedback.y plant.u")
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP, coupling="jacobi")
    for ratio, parts in ((0.3, [0.3]), (2.7, [1.0, 1.0, 0.7]), (3.0, [1.0, 1.0, 1.0])):
        found = one(path).prepare(step=ratio * STEP, stop=11 * ratio * STEP).run()["a.plant.y"]
        y, dy = 1.0, -3.0
        for value in found:
            assert value == pytest.approx(y, rel=1e-12)
            for part in parts:
                y, dy = y + part * STEP * dy, -3.0 * y


def test_refuses_a_step_that_its_components_cannot_take(loop, make, tmp_path):
    can_vary = b'canHandleVariableCommunicationStepSize="true"'
    fixed = repacked(
        make("gain", 2), tmp_path / "fixed.fmu", lambda _, content: content.replace(can_vary, b"")
    )
    loop.add("fixed", fixed)
    path = cosim.write_fmu(loop, tmp_path / "a.fmu", step=STEP)
    with (
        one(path).prepare(step=1.5 * STEP, stop=3 * STEP) as simulation,
        pytest.raises(cosim.SimulationError, match="expected a multiple of the components' step"),
    ):
        simulation.run()


def test_refuses_a_description_of_another_build(packed, tmp_path):
    token = fmpy.read_model_description(packed)
    token = token.guid or token.instantiationToken
    other = repacked(
        packed,
        tmp_path / "other.fmu",
        lambda name, data: data if "binaries" in name else data.replace(token.encode(), b"0" * 32),
    )
    with pytest.raises(cosim.SimulationError, match=r"the token is 0{32}, expected"):
        one(other).prepare(step=STEP, stop=STOP)


def test_a_container_has_no_algebraic_loop(make, tmp_path):
    gains = dict.fromkeys("ab", (make("gain"), {"k": 0.5}))
    system = joined(gains, "a.y b.u", "b.y a.u", name="circle")
    with pytest.raises(cosim.ConnectionFault, match=r"circle: algebraic loop a\.y -> b\.u -> b\.y"):
        cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP, coupling="jacobi")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"parameters": ["*.K"]}, cosim.ParameterError, "matches nothing that a container"),
        ({"step": 0.0}, cosim.ExperimentError, "expected a positive number"),
        ({"platforms": [ARM]}, cosim.FmuError, "has no binary for aarch64-linux"),
    ],
)
def test_says_what_it_cannot_show(loop, tmp_path, arguments, error, message):
    with pytest.raises(error, match=message):
        cosim.write_fmu(loop, tmp_path / "a.fmu", **({"step": STEP} | arguments))
    assert not list(tmp_path.iterdir())


def test_says_what_it_cannot_hold(loop, tmp_path):
    loop.set("plant.text", "hello")
    with pytest.raises(cosim.ParameterError, match=r"plant\.text: a container cannot set"):
        cosim.write_fmu(loop, tmp_path / "a.fmu", step=STEP)
    with pytest.raises(cosim.ConnectionFault, match="empty has no component"):
        cosim.write_fmu(cosim.System("empty"), tmp_path / "empty.fmu", step=0.1)
    assert not list(tmp_path.iterdir())
