import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Link, Scaling, Scenario

STEP, N = 0.1, 20


@pytest.fixture(params=["gauss_seidel", "jacobi"])
def simulation(make, request):
    """x -> gain -> integrator, with a few signals recorded or all."""
    system = cosim.System("line")
    system.add("sensor", make("gain"))
    system.add("plant", make("integrator", 3), {"k": 0.0})
    system.expose("x", "sensor.u")
    system.connect("sensor.y", "plant.u")
    with system.prepare(step=STEP, stop=N * STEP, coupling=request.param) as simulation:
        yield simulation


def run(simulation, scenario, x=np.sin):
    return simulation.run(inputs={"x": x}, scenario=scenario)


@pytest.mark.parametrize("name", ["x", "sensor.y", "plant.u"])
def test_an_offset_adds_to_a_signal_until_it_is_reset(simulation, name):
    signal = "sensor.y" if name == "plant.u" else name
    free = run(simulation, None)[signal]
    scenario = Scenario().offset(name, np.cos, begin=0.5, end=1.0).offset(name, 2.0, begin=0.8)
    changed = run(simulation, scenario.reset(name, at=1.5))
    added = np.zeros(N + 1)
    added[5:10] = np.cos(changed.time[5:10])
    added[8:15] += 2.0
    np.testing.assert_array_equal(changed[signal], free + added)
    again = run(simulation, scenario.reset(name, at=1.5).offset(name, 1.0, begin=1.8))[signal]
    np.testing.assert_array_equal(again[18:], free[18:] + 1.0)


def test_the_tables_of_a_scenario_count_as_memory(simulation, monkeypatch):
    monkeypatch.setattr("os.sysconf", lambda _: 40)  # 1600 bytes: 7 numbers at each point
    run(simulation, None)
    with pytest.raises(cosim.ExperimentError, match="21 points of 13 numbers"):
        run(simulation, Scenario().offset("x", 1.0).reset("x", at=1.0))


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        (Scenario().set("sensor.z", 1.0, at=0.0), "not a signal of the run"),
        (Scenario().override("x", np.nan), "not finite"),
        (Scenario().override("x", np.zeros(3)), "shape"),
    ],
)
def test_scenarios_that_cannot_be(simulation, scenario, message):
    with pytest.raises(cosim.SignalError, match=message):
        run(simulation, scenario)


def test_unrolled_steps_give_way_to_a_scenario_and_come_back(make):
    system = cosim.System("ring")
    system.add("sensor", make("gain"), {"k": -0.5})
    system.add("plant", make("integrator", 3), {"k": 1.0})
    system.connect("sensor.y", "plant.u")
    system.connect("plant.y", "sensor.u")
    scenario = Scenario().add_noise("sensor.y", 0.1, seed=1).stick("plant.y", 0.5, 0.9)
    values = []
    for compiled in (False, True):
        with system.prepare(step=STEP, stop=N * STEP, compiled=compiled) as simulation:
            runs = [simulation.run(scenario=s).values for s in (None, scenario, None)]
        np.testing.assert_array_equal(runs[0], runs[2])
        assert not np.array_equal(runs[0], runs[1])
        values.append(runs)
    np.testing.assert_array_equal(values[0], values[1])


def test_from_the_beginning_receivers_see_the_disturbed_value(make):
    system = cosim.System("late")
    for name in ("a", "b"):
        system.add(name, make("gain"), {"k": 2.0})
    system.connect("a.y", "b.u")
    system.expose("x", "a.u")
    for coupling in ("gauss_seidel", "jacobi"):
        with system.prepare(step=STEP, stop=N * STEP, coupling=coupling) as simulation:
            result = run(simulation, Scenario().set("a.y", 3.0, at=0.0))
        assert set(result["b.y"]) == {6.0}


def sensor_of(make, *receivers):
    system = cosim.System("connections")
    system.add("sensor", make("gain", y="mN"))
    system.expose("x", "sensor.u")
    for name in receivers:
        system.add(name, make("gain"))
        system.connect("sensor.y", f"{name}.u", Link(Scaling(1.0, 0.5)))
    return system


def test_a_connection_is_named_by_its_input_in_the_unit_of_that(make):
    with sensor_of(make, "plant").prepare(step=STEP, stop=N * STEP) as simulation:
        scenario = Scenario().set("plant.u", 3.0, at=0.5)
        result = run(simulation, scenario)
        free = run(simulation, None)
        np.testing.assert_allclose(result["plant.y"][5:], 3.0, rtol=1e-15)
        np.testing.assert_array_equal(result["plant.y"][:5], free["plant.y"][:5])
        noisy = run(simulation, Scenario().add_noise("plant.u", 0.1, 4))
        noise = 0.1 * np.random.default_rng(4).standard_normal(N + 1)
        np.testing.assert_allclose(noisy["plant.y"], free["plant.y"] + noise, rtol=1e-12)
        stuck = run(simulation, Scenario().stick("plant.u", 0.5))["plant.y"]
        np.testing.assert_array_equal(stuck[5:], free["plant.y"][4])


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        (
            Scenario().set("one.u", 1.0, 0.5),
            r"sensor\.y, .*also connected to two\.u.*name sensor\.y",
        ),
        (Scenario().set("sensor.u", 1.0, 0.5).set("x", 1.0, 0.5), "x, which occurs already"),
    ],
)
def test_one_of_several_receivers_is_not_disturbed_alone(make, scenario, message):
    with (
        sensor_of(make, "one", "two").prepare(step=STEP, stop=N * STEP) as simulation,
        pytest.raises(cosim.SignalError, match=message),
    ):
        run(simulation, scenario)


@pytest.mark.parametrize("name", ["x", "sensor.y", "plant.u"])
def test_a_stuck_signal_may_be_noisy(simulation, name):
    """The noise lies about the value that sticks, and adds up to no walk."""
    signal = "sensor.y" if name == "plant.u" else name
    free = simulation.run(inputs={"x": np.sin})[signal]
    noise = 0.1 * np.random.default_rng(5).standard_normal(N + 1)
    stuck = Scenario().stick(name, begin=0.5, end=1.5).add_noise(name, 0.1, 5, begin=0.8)
    result = run(simulation, stuck)[signal]
    np.testing.assert_array_equal(result[5:8], free[4])
    np.testing.assert_array_equal(result[8:15], free[4] + noise[8:15])
    np.testing.assert_array_equal(result[15:], free[15:] + noise[15:])
