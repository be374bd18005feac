"""In a process of its own a system does what it does here, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.coupling import ring
from stickslip import cosim, models
from stickslip.cosim.signals.signals import Table
from tests.cosim.single import one

STEP, STOP = 1e-3, 0.5


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    return tmp_path_factory.mktemp("ring")


def loop(fmus, version=2):
    system = ring.system(fmus, version)
    system.connections.pop("controller.y")
    system.expose("y", "controller.y")
    return system


def both(system, how, **arguments):
    spec = cosim.Specification(system, STEP, STOP, **how)
    with spec.prepare() as here, replace(spec, isolation="process").prepare() as there:
        assert there.order == here.order
        assert np.array_equal(there.time, here.time)
        results = here.run(**arguments), there.run(**arguments)
        assert there.effort == here.effort
        return results


def assert_same(one, other):
    assert other.names == one.names
    assert other.time.tobytes() == one.time.tobytes()
    assert other.values.tobytes() == one.values.tobytes()
    assert other.values.shape == one.values.shape
    assert other.units == one.units
    assert other.stopped == one.stopped


INPUT = {"inputs": {"y": 0.3}}
HOW = {
    "some": {"record": cosim.Record(["mass.v", "y"], every=7)},
    "last": {"record": cosim.Record("mass.*", keep="last")},
    "compiled": {"compiled": True, "constant_step": True, "coupling": "jacobi"},
}
RUNS = {
    "number": INPUT | {"parameters": {"controller.K_p": 50.0}},
    "function": {"inputs": {"y": lambda t: np.sin(t)}},
    "table": {"inputs": {"y": Table(np.array([0.0, 0.1003, 0.1003, 1]), np.array([0, 0, 1, 1.0]))}},
    "tunable": INPUT | {"tunable": {"controller.K_p": lambda t: 40.0 + t}},
}


@pytest.mark.thorough
@pytest.mark.slow
def test_whatever_is_recorded_and_fed(fmus):
    for how in HOW.values():
        assert_same(*both(loop(fmus), how, **INPUT))
    spec = cosim.Specification(loop(fmus, 3), STEP, STOP)
    with spec.prepare() as here, replace(spec, isolation="process").prepare() as there:
        for arguments in RUNS.values():
            assert_same(here.run(**arguments), there.run(**arguments))


def test_a_result_outlives_the_next_run_and_the_child(fmus):
    with loop(fmus).prepare(step=STEP, stop=STOP, isolation="process") as simulation:
        one = simulation.run(inputs={"y": 0.3})
        kept = one.values.copy()
        simulation.run(inputs={"y": -0.3})
    assert np.array_equal(one.values, kept)


def test_events_and_model_exchange_behind_the_general_path(tmp_path):
    system = one(
        models.build_fmu("stage", tmp_path), u="u", name="stage", interface="model_exchange"
    )
    assert_same(*both(system, {}, inputs={"u": 20.0}))


def test_state_and_progress(tmp_path):
    system = one(models.build_fmu("stage", tmp_path), u="u", name="stage")
    spec = cosim.Specification(system, STEP, STOP)
    reached = []
    with spec.prepare() as here, replace(spec, isolation="process").prepare() as there:
        whole = here.run(inputs={"u": 20.0})
        there.run(inputs={"u": 20.0}, until=0.2)
        path = there.save(tmp_path / "state")
        rest = there.resume(path, inputs={"u": 20.0}, progress=reached.append)
        assert_same(here.resume(path, inputs={"u": 20.0}), rest)
        assert np.array_equal(rest["stage.v"], whole["stage.v"][200:])
        assert reached[-1] == STOP
        assert reached == sorted(reached)


def test_a_run_that_an_fmu_ends(make):
    """Times are not sent: the parent knows all but the last one."""
    system = one(make("integrator", 3), {"u": 1.0, "fault": 11, "fault_time": 0.455})
    for how in ({"record": cosim.Record("a.y", every=7)}, {"record": cosim.Record(keep="last")}):
        here, there = both(system, how)
        assert here.stopped
        assert_same(here, there)


def test_mistakes_of_the_caller_are_those_of_the_caller(fmus):
    system = loop(fmus)
    with pytest.raises(cosim.ExperimentError, match="expected 'foreign', 'process'"):
        system.prepare(step=0.1, stop=1.0, isolation="thread")
    with pytest.raises(cosim.ExperimentError, match="timeout is 0"):
        cosim.Isolation(timeout=0)
    with system.prepare(step=STEP, stop=STOP, isolation="process") as simulation:
        with pytest.raises(cosim.ParameterError, match="no variable 'K_q'"):
            simulation.run({"controller.K_q": 1.0})
        with pytest.raises(cosim.SignalError, match="not finite"):
            simulation.run(inputs={"y": np.nan})
        with pytest.raises(cosim.SimulationError, match="halt a run"):
            simulation.save("nowhere")
        assert simulation.run(inputs={"y": 1.0}).stopped is None
