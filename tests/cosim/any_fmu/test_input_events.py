"""Exposed inputs that jump, at the points in time of a run and between them, against FMPy."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.signals.signals import slack
from tests.cosim.single import by_fmpy, one

STEP, STOP = 0.1, 2.0
KINDS = {"force": "f8", "trigger": "?"}
OUTPUTS = {"oscillator": ["position", "gain"], "stair": ["count", "level"]}
# Repeated times are jumps of force; trigger jumps wherever its value does. 0.7 lies at a point.
TIME = np.array([0.0, 0.33, 0.33, 0.334, 0.7, 0.7, 1.0, 1.25, 1.25, 2.0])
FORCE = np.array([0.0, 1.0, -1.0, 0.5, 0.5, 2.0, 2.0, 0.0, 1.0, 1.0])
TRIGGER = np.array([0, 0, 1, 1, 1, 0, 0, 1, 1, 0])


def both(path, name, time, values, kind="CoSimulation", **prepared):
    model = path.stem
    system = one(path)
    system.expose("u", f"a.{name}")
    signals = [time, (name, KINDS[name], values)]
    how = {"record_events": False, "relative_tolerance": prepared.get("tolerance")}
    theirs = by_fmpy(path, STEP, STOP, *OUTPUTS[model], inputs=signals, fmi_type=kind, **how)
    with system.prepare(step=STEP, stop=STOP, **prepared) as simulation:
        ours = simulation.run(inputs={"u": cosim.Table(time, values)})
    regular = [np.argmin(abs(theirs["time"] - t)) for t in ours.time]
    return [(ours[f"a.{output}"], theirs[output][regular]) for output in OUTPUTS[model]]


@pytest.mark.parametrize("interfaces", ["CS", "CS fixed"])  # the latter cannot stop in between
@pytest.mark.parametrize(
    ("model", "name", "values"), [("oscillator", "force", FORCE), ("stair", "trigger", TRIGGER)]
)
def test_co_simulation_stops_at_jumps_as_in_fmpy(export, version, interfaces, model, name, values):
    for ours, theirs in both(export(model, version, interfaces), name, TIME, values):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("seed", range(5))
def test_any_table_gives_the_bits_of_fmpy(export, seed):
    rng = np.random.default_rng(seed)
    time = np.sort(np.concatenate([rng.uniform(-0.1, 2.2, 30), STEP * rng.integers(0, 20, 10)]))
    time = np.sort(np.concatenate([time, rng.choice(time, 15)]))
    path = export("oscillator", 2, "CS")
    for ours, theirs in both(path, "force", time, rng.normal(size=len(time)), compiled=seed == 0):
        np.testing.assert_array_equal(ours, theirs)


def test_a_jump_a_rounding_error_beside_a_point_lies_at_it():
    for n in range(1, 2000):
        jump = cosim.Table([0.0, n / 1000, n / 1000, 2.0], [0, 0, 1, 1])
        assert jump.sample(np.array([n * 0.001])) == 1


def test_a_jump_at_most_the_slack_behind_a_point_lies_at_it(export, version):
    """To the last bit, so that neither a point in time nor an event is on both sides of it."""
    system = one(export("stair", version, "ME"), {"period": 1e9}, u="trigger")
    with system.prepare(step=0.125, stop=1.0) as simulation:
        latest = 0.125 + slack(1.0, 0.125)
        for jump, row in ((0.125, 1), (latest, 1), (np.nextafter(latest, 1.0), 2)):
            result = simulation.run(inputs={"u": cosim.Table([0.0, jump], [0, 1])})
            assert np.argmax(result["a.level"] == 10) == row


def test_with_constant_steps_a_jump_waits_for_the_next_point(export):
    system = one(export("stair", 2, "CS"), u="trigger")
    jump = {"u": cosim.Table([0.0, 0.33], [0, 1])}
    with system.prepare(step=STEP, stop=STOP) as simulation:
        assert simulation.run(inputs=jump)["a.level"][4] == 10
    with system.prepare(step=STEP, stop=STOP, constant_step=True) as simulation:
        np.testing.assert_array_equal(simulation.run(inputs=jump)["a.level"][4:6], [0, 10])


def test_model_exchange_has_the_events_of_fmpy_at_jumps(export, version):
    stair = export("stair", version, "ME")
    for ours, theirs in both(stair, "trigger", TIME, TRIGGER, "ModelExchange"):
        np.testing.assert_array_equal(ours, theirs)
    flat = np.repeat([0.0, 1.0, -1.0, 2.0], [2, 2, 4, 2])  # FMPy holds it between two points
    time = np.array([0.0, 0.33, 0.33, 0.7, 0.7, 0.9, 1.0, 1.25, 1.25, 2.0])
    (ours, theirs), (gain, gain_of_fmpy) = both(
        export("oscillator", version, "ME"), "force", time, flat, "ModelExchange", tolerance=1e-8
    )
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
    np.testing.assert_array_equal(gain, gain_of_fmpy)
