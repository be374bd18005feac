"""Files that stray from the standard or leave something open, such as the tolerance."""

import logging
import pickle
import threading

import fmpy
import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.fmu import instance as once
from tests.cosim.single import one


def test_the_only_library_of_the_folder_is_taken_with_a_warning(export, version, caplog):
    path = export("stair", version, binary_name="libstair_linux")
    with caplog.at_level(logging.WARNING, "stickslip.cosim.fmu.fmu"):
        system = cosim.System()
        system.add("a", path)
    assert "libstair_linux" in caplog.text
    assert "modelIdentifier is 'stair'" in caplog.text
    system.prepare(step=0.1, stop=0.2).run()


def test_scheduled_execution_alone_cannot_be_run(export):
    with pytest.raises(cosim.FmuError, match="only Scheduled Execution; export the model"):
        cosim.Fmu(export("stair", 3, "SE"))


def test_an_interface_it_does_not_have(export):
    with pytest.raises(cosim.FmuError, match="no interface 'model_exchange'; it has co_simulation"):
        cosim.Fmu(export("stair", 2, "CS"), interface="model_exchange")


def test_interfaces_are_listed_and_pickled(export):
    fmu = cosim.Fmu(export("stair", 2, "ME CS"), interface="model_exchange")
    assert fmu.interfaces == ("co_simulation", "model_exchange")
    assert pickle.loads(pickle.dumps(fmu)).interface == "model_exchange"  # noqa: S301 - our own bytes
    assert cosim.Fmu(export("stair", 2, "ME CS")).interface == "co_simulation"
    assert cosim.Fmu(export("stair", 2, "ME")).interface == "model_exchange"


def test_one_instance_per_process(export):
    once = 'canBeInstantiatedOnlyOncePerProcess="true"'
    path = export("stair", 2, "CS", once)
    system = cosim.System("first")
    system.add("a", path)
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
    system = cosim.System()
    system.add("a", export("stair", 2, "CS", 'canBeInstantiatedOnlyOncePerProcess="true"'))
    forgotten = [system.prepare(step=0.1, stop=0.2)]
    present = once._present

    def collecting():
        forgotten.clear()  # as a garbage collection may do at any time
        return present()

    monkeypatch.setattr(once, "_present", collecting)
    thread = threading.Thread(target=once.release, args=(object(),), daemon=True)
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
    assert fmpy.simulate_fmu(str(path), stop_time=0.1, output=["told"])["told"][-1] == told


@pytest.mark.parametrize("experiment", ["", PROPOSED, 'tolerance="-1"'])
def test_model_exchange_takes_the_tolerance_that_fmpy_takes(export, version, experiment):
    path = export("oscillator", version, "ME", experiment=experiment)
    system = one(path)
    ours = system.prepare(step=0.1, stop=5.0).run()
    usual = {"relative_tolerance": 1e-5} if "-1" in experiment else {}
    theirs = fmpy.simulate_fmu(
        str(path), stop_time=5.0, output_interval=0.1, output=["position"], **usual
    )
    np.testing.assert_array_equal(ours["a.position"], theirs["position"])


@pytest.mark.parametrize("tolerance", [0.0, -1e-6, 1.0, float("nan")])
def test_what_is_no_tolerance_is_refused(export, tolerance):
    system = one(export("oscillator", 3))
    with pytest.raises(cosim.ExperimentError, match="between 0 and 1"):
        system.prepare(step=0.1, stop=1.0, tolerance=tolerance)
