"""Files that stray from the standard or leave something open; tunable parameters."""

import logging
import pickle
import threading
from weakref import WeakKeyDictionary

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.fmu import instance as once
from stickslip.simulation import simulate
from tests.cosim.single import by_fmpy, edited, halves, joined, one, repacked, saves


def test_the_only_library_of_the_folder_is_taken_with_a_warning(export, version, caplog):
    path = export("stair", version, binary_name="libstair_linux")
    with caplog.at_level(logging.WARNING, "stickslip.cosim.fmu.fmu"):
        system = one(path)
    assert "libstair_linux" in caplog.text
    assert "modelIdentifier is 'stair'" in caplog.text
    system.prepare(step=0.1, stop=0.2).run()


def test_scheduled_execution_alone_cannot_be_run(export):
    with pytest.raises(cosim.FmuError, match="only Scheduled Execution; export the model"):
        cosim.Fmu(export("stair", 3, "SE"))


def test_interfaces_are_listed_and_pickled(export):
    fmu = cosim.Fmu(export("stair", 2, "ME CS"), interface="model_exchange")
    assert fmu.interfaces == ("co_simulation", "model_exchange")
    assert pickle.loads(pickle.dumps(fmu)).interface == "model_exchange"  # noqa: S301 - our own bytes
    assert cosim.Fmu(export("stair", 2, "ME CS")).interface == "co_simulation"
    assert cosim.Fmu(export("stair", 2, "ME")).interface == "model_exchange"


def test_one_instance_per_process(export):
    once = 'canBeInstantiatedOnlyOncePerProcess="true"'
    path = export("stair", 2, "CS", once)
    system = joined({"a": path}, name="first")
    with system.prepare(step=0.1, stop=0.2) as simulation:
        simulation.run()
        with pytest.raises(cosim.SimulationError, match="only once per process, and a of first"):
            system.prepare(step=0.1, stop=0.2)
        simulation.run()
    system.add("b", path)
    with pytest.raises(cosim.SimulationError, match="only once per process"):
        system.prepare(step=0.1, stop=0.2)


def test_a_simulation_collected_while_another_gives_up_does_not_wait_for_itself(
    export, monkeypatch
):
    system = one(export("stair", 2, "CS", 'canBeInstantiatedOnlyOncePerProcess="true"'))
    forgotten = [system.prepare(step=0.1, stop=0.2)]

    class Collecting(WeakKeyDictionary):
        def pop(self, *arguments):
            forgotten.clear()  # as a garbage collection may do at any time
            return super().pop(*arguments)

    monkeypatch.setattr(once, "_held", Collecting(once._held))
    thread = threading.Thread(target=once.release, args=(system,), daemon=True)
    thread.start()
    thread.join(10)
    assert not thread.is_alive()
    system.prepare(step=0.1, stop=0.2).close()


def test_an_fmu_that_needs_its_tool_says_so(export, caplog):
    with caplog.at_level(logging.WARNING, "stickslip.cosim.fmu.fmu"):
        cosim.Fmu(export("stair", 2, "CS", 'needsExecutionTool="true"'))
    assert "needs the tool" in caplog.text


PROPOSED = 'tolerance="1e-3"'


@pytest.mark.parametrize(("experiment", "told"), [("", 0.0), (PROPOSED, 1e-3)])
@pytest.mark.parametrize("recorded", ["a.told", "a.*"])  # as the loop takes it, on the general path
def test_co_simulation_is_told_what_it_proposed_unless_another_is_given(
    export, version, experiment, told, recorded
):
    path = export("feedthrough", version, "CS", experiment=experiment)
    system = one(path)
    times = {"step": 0.1, "stop": 0.1, "record": [recorded]}
    assert system.prepare(**times).run()["a.told"][-1] == told
    assert system.prepare(**times, tolerance=1e-4).run()["a.told"][-1] == 1e-4
    assert by_fmpy(path, None, 0.1, "told")["told"][-1] == told


@pytest.mark.parametrize("experiment", ["", PROPOSED, 'tolerance="-1"'])
def test_model_exchange_takes_the_tolerance_that_fmpy_takes(export, version, experiment):
    path = export("oscillator", version, "ME", experiment=experiment)
    system = one(path)
    ours = system.prepare(step=0.1, stop=5.0).run()
    usual = {"relative_tolerance": 1e-5} if "-1" in experiment else {}
    theirs = by_fmpy(path, 0.1, 5.0, "position", fmi_type=None, **usual)
    np.testing.assert_array_equal(ours["a.position"], theirs["position"])


@pytest.mark.parametrize("tolerance", [0.0, -1e-6, 1.0, float("nan")])
def test_what_is_no_tolerance_is_refused(export, tolerance):
    system = one(export("oscillator", 3))
    with pytest.raises(cosim.ExperimentError, match="between 0 and 1"):
        system.prepare(step=0.1, stop=1.0, tolerance=tolerance)


STEP, N = 0.1, 20


def steps(name, *values):
    """Return a parameter that has the first value, and others from their times on."""
    times, values = zip((0.0, values[0]), *values[1:], strict=True)
    return {name: cosim.Table(times, values, held=True)}


def run(system, tunable, **how):
    with system.prepare(step=STEP, stop=N * STEP, **how) as simulation:
        plain = simulation.run().values
        result = simulation.run(tunable=tunable)
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
    late = run(ball(export, version, interfaces), steps("a.e", 0.9, (0.3, 0.3)), **fine)
    start = run(ball(export, version, interfaces, e=0.3), None, **fine)
    old = run(ball(export, version, interfaces), None, **fine)
    error = 1e-5 if interfaces == "ME" else 0.0
    np.testing.assert_allclose(late["a.height"], start["a.height"], rtol=0, atol=error)
    assert np.ptp(late["a.height"] - old["a.height"]) > 0.1


@pytest.fixture
def gain(make, version):
    return one(make("gain", version), {"k": 2.0}, "u")


@pytest.mark.parametrize(
    ("coupling", "record"),
    [("jacobi", None), ("jacobi", ["a.y"]), (cosim.Coupling("iterative", degree=0), ["a.y"])],
)
def test_from_its_time_on_each_step_has_the_new_value(gain, version, coupling, record):
    compiled = version == 3 and coupling == "jacobi" and record is not None
    tunable = steps("a.k", 2.0, (0.5, 5.0), (1.0, 7.0), (1.5, 5.0))
    expected = np.full(N + 1, 2.0)
    expected[6:] = 5.0  # the output at t[6] is that of the step from t[5]
    expected[11:16] = 7.0
    how = {"compiled": compiled, "coupling": coupling, "record": record}
    with gain.prepare(step=STEP, stop=N * STEP, **how) as simulation:
        result = simulation.run(inputs={"u": 1.0}, tunable=tunable)
        np.testing.assert_array_equal(result["a.y"], expected)
        given = simulation.run({"a.k": 3.0}, inputs={"u": 1.0}, tunable=tunable)
        np.testing.assert_array_equal(given["a.y"], [3.0, *expected[1:]])
        noise = np.random.default_rng(3).standard_normal(N + 1)
        noisy = simulation.run(inputs={"u": 1.0}, tunable={"a.k": noise})
        np.testing.assert_array_equal(noisy["a.y"][1:], noise[:-1])
        plain = simulation.run(inputs={"u": 1.0})
        np.testing.assert_array_equal(plain["a.y"], np.full(N + 1, 2.0))


def test_integers_and_booleans_change_too(make):
    system = one(make("gain"))
    tunable = steps("a.n", 0, (0.5, 4)) | steps("a.flag", 0, (1.0, 1))
    result = run(system, tunable, record=["a.sum"])["a.sum"]
    np.testing.assert_array_equal(result, np.repeat([0.0, 4.0, 14.0], [6, 5, 10]))


def test_changes_go_on_in_a_resumed_run(export, tmp_path):
    system = one(export("ball", 3, "CS events", saves(3)))
    for at in (0.3, 1.0, 1.2):
        tunable = steps("a.e", 0.9, (at, 0.3), (1.6, 0.9))
        how = {"step": STEP, "stop": N * STEP, "until": 1.0, "tunable": tunable}
        whole, rest = halves(system, tmp_path / "a.state", {"a.e": 0.9}, **how)
        np.testing.assert_array_equal(rest.values, whole.values[10:])


@pytest.mark.parametrize(
    ("tunable", "message"),
    [
        ({"a.fault_time": 1.0}, "a.fault_time is a fixed parameter"),
        ({"a.k": 1e9}, "outside its range -1000.0 .. 1000.0"),
        ({"a.q": 1.0}, "no variable 'q'"),
        ({"a.k": np.zeros(3)}, "shape"),
        ({"a.k": np.nan}, "not finite"),
        ({"a.text": 1.0}, "a.text is a fixed parameter"),
    ],
)
def test_what_cannot_change_is_refused(gain, tunable, message):
    with pytest.raises(cosim.SignalError, match=message):
        run(gain, tunable)


def test_arrays_are_refused(export):
    system = one(export("state_space", 3, "CS"))
    for name in ("a.A", "a.A[1,1]"):
        with pytest.raises(cosim.SignalError, match="is of type array"):
            run(system, {name: 1.0})


def gained(path):
    """Return the result of three times two."""
    return simulate(path, stop=0.1, step=0.1, parameters={"k": 3.0}, inputs={"u": 2.0})


def test_missing_dependencies_mean_all_inputs(make, tmp_path):
    dependencies = {'index="2" dependencies="1"': 'index="2"'}
    path = edited(make("gain"), tmp_path / "changed.fmu", dependencies)
    assert cosim.Fmu(path).feedthrough["y"] == {"u"}


def test_an_identifier_with_a_hyphen_names_a_file_all_the_same(make, tmp_path):
    identifier = {'modelIdentifier="gain"': 'modelIdentifier="2-gain"'}
    path = edited(make("gain"), tmp_path / "2-gain.fmu", identifier)
    repacked(path, path, lambda _, content: content, lambda name: name.replace("/gain", "/2-gain"))
    assert gained(path)["2-gain.y"][-1] == 6.0


def test_an_fmu_without_outputs_shows_its_local_variables(make, tmp_path, version):
    unlisted = {'"output"': '"local"', "<Outputs>.*</Outputs>|<Output [^>]*/>": ""}
    path = edited(make("gain", version), tmp_path / "gain.fmu", unlisted)
    result = gained(path)
    assert result["gain.y"][-1] == 6.0
    assert all(
        cosim.Fmu(path).variables[n.removeprefix("gain.")].causality != "parameter"
        for n in result.names[1:]
    )
