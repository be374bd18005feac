"""Every status at every call: what docs/statuses.md says, and the next run as if nothing was.

An FMU may log with an environment that is not the one it was given: its message is kept.
"""

import ctypes
import functools
import logging
import re
import subprocess
import sys

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Adaptive, Coupling
from stickslip.cosim.run import resets
from tests.corpus.hostile import faults
from tests.cosim.single import joined, one
from tests.kept import further

# function -> which of its calls fails
COMMON = {"SetReal": 3, "GetReal": 5, "Reset": 1, "EnterInitializationMode": 1}
COMMON |= {"ExitInitializationMode": 1, "Terminate": 1}
STEPS, SETUP, TYPED = {"DoStep": 4}, {"SetupExperiment": 1}, {"GetInteger": 5}
EXCHANGE = {"SetTime": 9, "EnterContinuousTimeMode": 1, "UpdateDiscreteStates": 1}
EXCHANGE |= {"SetContinuousStates": 7, "GetContinuousStates": 1, "GetDerivatives": 7}
EXCHANGE |= {"GetNominals": 1, "CompletedIntegratorStep": 2}
COUNTED = {"GetNumberOfContinuousStates": 1, "GetNumberOfEventIndicators": 1}
EVENTS = {"EnterStepMode": 1, "UpdateDiscreteStates": 1}
ROLLBACK = {"GetState": 2, "SetState": 1}
NOMINALS = {"GetNominals": "GetNominalsOfContinuousStates"}
NAMES = {  # by version, where they are not those above
    2: {"UpdateDiscreteStates": "NewDiscreteStates", **NOMINALS}
    | {"GetState": "GetFMUstate", "SetState": "SetFMUstate"},
    3: {"SetReal": "SetFloat64", "GetReal": "GetFloat64", "GetInteger": "GetInt32", **NOMINALS}
    | {"GetState": "GetFMUState", "SetState": "SetFMUState"}
    | {"GetDerivatives": "GetContinuousStateDerivatives"},
}
CASES = [
    (version, kind, function)
    for version in (2, 3)
    for kind, functions in {
        "plain": COMMON | STEPS | (SETUP if version == 2 else {}),
        "typed": COMMON | STEPS | TYPED | (SETUP if version == 2 else {}),
        "exchange": COMMON | EXCHANGE | (SETUP if version == 2 else COUNTED),
        "events": COMMON | STEPS | EVENTS if version == 3 else {},
        "adaptive": COMMON | STEPS | ROLLBACK,
    }.items()
    for function in functions
]
NTH = COMMON | STEPS | SETUP | TYPED | EXCHANGE | COUNTED | EVENTS | ROLLBACK
WORDS = {2: "returned discard", 3: "returned error", 4: "returned fatal", 5: "returned pending"}
WARNING, DISCARD, FATAL = 1, 2, 4
STATUSES = (1, 2, 3, 4, 5, 42, 101, -1)


class Rig:
    """One FMU under a simulation, and what it counts itself."""

    def __init__(self, path, version, kind):
        self.kind = kind
        of_fmu = "plain" if kind == "adaptive" else kind
        fmu = faults.write(path, faults.ARMED_ELSEWHERE, version, of_fmu)
        self.system = one(fmu, {"k": 2.0}, "u")
        if kind == "adaptive":  # the step follows what is connected
            self.system.add("b", faults.write(path.with_name("b.fmu"), "none 1 0", version))
            self.system.connect("a.y", "b.u")
        self._library = ctypes.CDLL(str(self.system.components["a"].binary))

    def prepare(self):
        adaptive = Coupling(degree=1, adaptive=Adaptive(1e-4))
        coupling = adaptive if self.kind == "adaptive" else "gauss_seidel"
        return self.system.prepare(step=0.1, stop=1.0, coupling=coupling)

    def arm(self, plan="none 1 0"):
        self._library.arm(plan.encode())

    def counts(self):
        found = (ctypes.c_int * 3)()
        self._library.counts(found)
        return np.array(found)


@pytest.fixture(scope="module")
def rigs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("faults")
    return functools.cache(lambda n, kind: Rig(folder / f"{kind}{n}.fmu", n, kind))


def drive(simulation):
    return simulation.run(inputs={"u": np.linspace(0.0, 3.0, 11) ** 2}).values


def recovers(kind, function, status):
    """Whether a run goes on: the solver or the importer tries smaller steps."""
    tried_again = kind != "exchange" and function == "DoStep"
    by_solver = kind == "exchange" and function in {
        "SetTime", "SetContinuousStates", "GetDerivatives",
    }  # fmt: skip
    return status == DISCARD and (tried_again or by_solver)


def words_of(version, status):
    unknown = f"returned the unknown status {status}"
    return unknown if version == 3 and status == 5 else WORDS.get(status, unknown)


@pytest.mark.parametrize(("version", "kind", "function"), CASES)
def test_every_status(rigs, version, kind, function, caplog, monkeypatch):
    rig = rigs(version, kind)
    nth = NTH[function]
    call = f"fmi{version}{NAMES[version].get(function, function)}"
    for status in STATUSES:
        monkeypatch.setattr(resets, "lines", {})
        rig.arm()
        caplog.clear()
        before_all = rig.counts()
        with rig.prepare() as simulation, caplog.at_level(logging.WARNING):
            before = drive(simulation)
            rig.arm(f"{function} {nth} {status}")
            if status == WARNING:
                np.testing.assert_array_equal(drive(simulation), before)
                (record,) = caplog.records
                assert record.getMessage().startswith(f"a: {call} returned warning at t = ")
                assert "the FMU says: " in record.getMessage()
            elif recovers(kind, function, status):
                np.testing.assert_allclose(drive(simulation), before, rtol=0.02)
            elif function == "Reset":  # a new instance does as well
                np.testing.assert_array_equal(drive(simulation), before)
                (record,) = caplog.records
                words = words_of(version, status)
                assert f"cannot be used again after a reset: a: {call} {words}" in record.message
                assert "the FMU says: " in record.message
            else:
                with pytest.raises(cosim.SimulationError) as error:
                    drive(simulation)
                assert str(error.value).startswith(f"a: {call} {words_of(version, status)}")
                assert (
                    " t = " in str(error.value)
                    or "initialisation" in str(error.value)
                    or (function == "Terminate" and "after the last step" in str(error.value))
                )
                assert "the FMU says: " in str(error.value)
            rig.arm()
            np.testing.assert_array_equal(drive(simulation), before)
        alive, states, abused = rig.counts() - before_all
        assert abused == 0
        assert alive == (status == FATAL)
        assert states == 0 or status == FATAL


@pytest.mark.parametrize(("step", "longest", "parts"), [(0.1, 30, 4), (1.0, 1, 1024)])
def test_discarded_steps_are_tried_in_parts(rigs, version, step, longest, parts):
    """A step (s) that the FMU discards above so many ms gives what so many short steps give."""
    rig = rigs(version, "plain")
    rig.arm()
    expected = rig.system.prepare(step=step / parts, stop=1.0).run({"a.u": 1.0}).values[::parts]
    with rig.system.prepare(step=step, stop=1.0) as simulation:
        rig.arm(f"Long {longest} 0")
        for _ in range(2):
            result = simulation.run({"a.u": 1.0})
            assert result.stopped is None
            np.testing.assert_allclose(result["a.y"], expected[:, 1], rtol=1e-12)
    with rig.system.prepare(step=step, stop=1.0) as simulation:
        simulation.start({"a.u": 1.0})
        with pytest.raises(cosim.SimulationError, match=r"a discarded a step; begin the run again"):
            simulation.step()
        simulation.start({"a.u": 1.0})
        assert simulation.step()["a.y"] == pytest.approx(expected[1, 1], rel=1e-12)
    rig.arm()


def test_fatal_buries_the_instances_of_other_simulations_too(rigs):
    rig = rigs(2, "plain")
    rig.arm()
    abused = rig.counts()[2]
    with rig.prepare() as one, rig.prepare() as other:
        before = drive(other)
        drive(one)
        other.start()
        rig.arm("DoStep 3 4")
        with pytest.raises(cosim.SimulationError, match="fatal"):
            drive(one)
        rig.arm()
        with pytest.raises(cosim.SimulationError, match="expected a run by steps"):
            other.step()
        np.testing.assert_array_equal(drive(other), before)
        np.testing.assert_array_equal(drive(one), before)
    assert rig.counts()[2] == abused


@pytest.mark.parametrize(
    "function", ["GetState", "SerializedSize", "Serialize", "Deserialize", "SetState", "FreeState"]
)
def test_every_status_while_a_state_is_saved_and_resumed(rigs, tmp_path, version, function):
    rig = rigs(version, "plain")
    for status in (2, 3, 4, 5, 42, -1):
        rig.arm()
        before_all = rig.counts()
        with rig.prepare() as simulation:
            whole = simulation.run({"a.u": 1.0}).values
            simulation.run({"a.u": 1.0}, until=0.5)
            path = simulation.save(tmp_path / "state")
            rig.arm(f"{function} 1 {status}")
            call = simulation.resume if function == "Deserialize" else simulation.save
            call = simulation.resume if function == "SetState" else call
            with pytest.raises(cosim.SimulationError, match=rf"^a: fmi{version}\w+ returned"):
                call(path)
            rig.arm()
            np.testing.assert_array_equal(simulation.resume(path).values, whole[5:])
        alive, states, abused = rig.counts() - before_all
        assert abused == 0
        assert alive == (status == FATAL)
        assert states == 0 or status == FATAL


@pytest.mark.parametrize(
    ("plan", "words"),
    [("Nothing 1 0", "gave no state"), ("Freeze 1 0", "did not bring back the state")],
)
def test_a_step_that_cannot_be_taken_back_is_noticed(rigs, version, plan, words):
    rig = rigs(version, "adaptive")
    rig.arm()
    with rig.prepare() as simulation:
        before = drive(simulation)
    with rig.prepare() as simulation:
        rig.arm(plan)
        with pytest.raises(cosim.SimulationError, match=rf"^a.*: fmi{version}\w+ {words}"):
            drive(simulation)
        rig.arm()
        np.testing.assert_array_equal(drive(simulation), before)


def test_warnings_are_counted_and_no_flood(rigs, caplog):
    rig = rigs(2, "plain")
    rig.arm("DoStep 0 1")
    with rig.prepare() as simulation, caplog.at_level(logging.WARNING):
        for _ in range(20):
            drive(simulation)
    rig.arm()
    (record,) = caplog.records
    assert "t = 0 s" in record.getMessage()
    assert record.getMessage().endswith("(warnings in this run: 10)")


def test_a_warning_in_a_process_of_its_own_is_logged_here(tmp_path, caplog):
    system = one(faults.write(tmp_path / "a.fmu", "DoStep 4 1"))
    with (
        system.prepare(step=0.1, stop=1.0, isolation="process") as simulation,
        caplog.at_level(logging.WARNING),
    ):
        simulation.run()
    (record,) = caplog.records
    assert record.getMessage().startswith("a: fmi2DoStep returned warning at t = 0.3 s")


FOREIGN = 1  # the address 1, see faults.c
SAID = re.compile("the FMU says: (call [0-9]+|it) broke")  # see faults.c


def pair(folder, plan, version, kind, first="none 1 0"):
    """Return a system of two: the first never fails, the second as planned."""
    plans = {"sound": first, "broken": plan}
    fmus = {n: faults.write(folder / f"{n}.fmu", p, version, kind) for n, p in plans.items()}
    return joined(fmus)


@pytest.mark.slow
@pytest.mark.parametrize("environment", range(6))
@pytest.mark.parametrize("kind", ["plain", "typed"])
def test_the_message_of_a_step_that_fails(tmp_path, version, kind, environment):
    compiled = (version, kind) == (3, "plain")
    system = pair(tmp_path, f"DoStep 0 3 {environment}", version, kind)
    with (
        system.prepare(step=0.1, stop=1.0, compiled=compiled) as simulation,
        pytest.raises(cosim.SimulationError) as error,
    ):
        simulation.run()
    assert str(error.value).startswith(f"broken: fmi{version}DoStep returned error")
    assert SAID.search(str(error.value))


@pytest.mark.slow
def test_a_message_does_not_pass_to_another_component_later(tmp_path, version):
    """The first answers OK after it has logged an error; the second fails later, saying nothing."""
    system = pair(tmp_path, f"Silent 6 3 {FOREIGN}", version, "plain", f"Say 2 3 {FOREIGN}")
    with (
        system.prepare(step=0.1, stop=1.0) as simulation,
        pytest.raises(cosim.SimulationError, match=r"^broken: \w+DoStep returned error") as error,
    ):
        simulation.run()
    assert "the FMU says" not in str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("call", ["DoStep", *further("SetReal", "Terminate")])
def test_in_a_container(tmp_path, call):
    """It passes on what its component says, to a tool that is not ours."""
    plan = f"{call} {1 if call == 'Terminate' else 4} 3 {FOREIGN}"
    system = pair(tmp_path, plan, 2, "plain")
    system.expose("u", "broken.u")
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=0.1)
    script = (
        "import fmpy, sys\n"
        "try:\n"
        f"    fmpy.simulate_fmu({str(path)!r}, stop_time=1.0, output_interval=0.1,"
        " logger=lambda *a: print(a[-1].decode()))\n"
        "except Exception as error:\n"
        "    print(type(error).__name__)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-500:]
    assert "broken: " in done.stdout
    assert "broke%" in done.stdout or "broke " in done.stdout
