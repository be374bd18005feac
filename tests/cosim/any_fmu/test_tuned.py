"""Tunable parameters change during a run, in each version and interface as the standard has it."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Scenario
from tests.cosim.single import halves, one, saves

STEP, N = 0.1, 20


def run(system, scenario, **how):
    with system.prepare(step=STEP, stop=N * STEP, **how) as simulation:
        plain = simulation.run().values
        result = simulation.run(scenario=scenario)
        np.testing.assert_array_equal(simulation.run().values, plain)  # nothing stays behind
    return result


def ball(export, version, interfaces, **parameters):
    return one(export("ball", version, interfaces), parameters)


@pytest.mark.parametrize(
    ("version", "interfaces"), [(2, "CS"), (3, "CS"), (3, "CS events"), (2, "ME"), (3, "ME")]
)
def test_a_ball_bounces_with_the_new_restitution(export, version, interfaces):
    """It first falls to the ground at t = 0.45 s, so a change at 0.3 s is as good as a start."""
    fine = {"tolerance": 1e-8}  # of the solver
    late = run(ball(export, version, interfaces), Scenario().set("a.e", 0.3, at=0.3), **fine)
    start = run(ball(export, version, interfaces, e=0.3), None, **fine)
    old = run(ball(export, version, interfaces), None, **fine)
    error = 1e-5 if interfaces == "ME" else 0.0
    np.testing.assert_allclose(late["a.height"], start["a.height"], rtol=0, atol=error)
    assert np.ptp(late["a.height"] - old["a.height"]) > 0.1


@pytest.fixture(params=[2, 3])
def gain(make, request):
    system = one(make("gain", request.param), {"k": 2.0})
    system.expose("x", "a.u")
    return system


@pytest.mark.parametrize(
    ("coupling", "compiled", "record"),
    [
        *(("jacobi", False, None), ("jacobi", True, ["a.y"])),
        (cosim.Coupling("iterative", degree=0), False, ["a.y"]),
    ],
)
def test_from_its_time_on_each_step_has_the_new_value(gain, compiled, coupling, record):
    scenario = Scenario().set("a.k", 5.0, at=0.5).override("a.k", 7.0, 1.0, 1.5)
    expected = np.full(N + 1, 2.0)
    expected[6:] = 5.0  # the output at t[6] is that of the step from t[5]
    expected[11:16] = 7.0
    how = {"compiled": compiled, "coupling": coupling, "record": record}
    with gain.prepare(step=STEP, stop=N * STEP, **how) as simulation:
        result = simulation.run(inputs={"x": 1.0}, scenario=scenario)
        np.testing.assert_array_equal(result["a.y"], expected)
        given = simulation.run({"a.k": 3.0}, inputs={"x": 1.0}, scenario=scenario)
        np.testing.assert_array_equal(given["a.y"], np.where(expected == 2.0, 3.0, expected))
        noisy = simulation.run(inputs={"x": 1.0}, scenario=Scenario().add_noise("a.k", 0.1, 3))
        noise = 0.1 * np.random.default_rng(3).standard_normal(N + 1)
        np.testing.assert_array_equal(noisy["a.y"][1:], 2.0 + noise[:-1])
        plain = simulation.run(inputs={"x": 1.0})
        np.testing.assert_array_equal(plain["a.y"], np.full(N + 1, 2.0))


def test_integers_and_booleans_change_too(make):
    system = one(make("gain"))
    scenario = Scenario().set("a.n", 4, at=0.5).set("a.flag", 1, at=1.0)
    result = run(system, scenario, record=["a.sum"])["a.sum"]
    np.testing.assert_array_equal(result, np.repeat([0.0, 4.0, 14.0], [6, 5, 10]))


def test_changes_go_on_in_a_resumed_run(export, tmp_path):
    system = one(export("ball", 3, "CS events", saves(3)))
    for at in (0.3, 1.0, 1.2):
        scenario = Scenario().override("a.e", 0.3, at, 1.6)  # then back to what the run began with
        how = {"step": STEP, "stop": N * STEP, "until": 1.0, "scenario": scenario}
        whole, rest = halves(system, tmp_path / "a.state", {"a.e": 0.9}, **how)
        np.testing.assert_array_equal(rest.values, whole.values[10:])


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        (Scenario().set("a.fault_time", 1.0, 0.5), "a.fault_time is a fixed parameter"),
        (Scenario().set("a.k", 1e9, 0.5), "outside its range -1000.0 .. 1000.0"),
        (Scenario().set("a.q", 1.0, 0.5), "not a signal of the run .* nor a parameter"),
        (Scenario().set("a.text", 1.0, 0.5), "a.text is a fixed parameter"),
    ],
)
def test_what_cannot_change_is_refused(gain, scenario, message):
    with pytest.raises(cosim.SignalError, match=message):
        run(gain, scenario)


def test_arrays_are_refused(export):
    system = one(export("state_space", 3, "CS"))
    for name in ("a.A", "a.A[1,1]"):
        with pytest.raises(cosim.SignalError, match=r"tunable parameter \(array\)"):
            run(system, Scenario().set(name, 1.0, 0.5))
