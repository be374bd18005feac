"""Reset, save, restore, serialise; instances beside one another; calls that are not allowed."""

import ctypes
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from stickslip import models

ERROR = 3


def test_a_reset_instance_equals_a_fresh_one(some_fmu, slave, identical):
    used, fresh = slave(some_fmu), slave(some_fmu)
    used.initialize(some_fmu.settings(), start=0.0).run(0, 60)
    used.api.reset()
    assert identical(used.everything(), fresh.everything())
    settings = some_fmu.settings()
    a = used.initialize(settings).run(0, 60)
    b = fresh.initialize(settings).run(0, 60)
    assert identical(a, b)
    assert len(np.unique(a, axis=0)) == 60


def test_a_restored_state_goes_on_as_before(fmu, slave, identical):
    instance = slave(fmu).initialize(fmu.settings())
    instance.run(0, 30)
    state = instance.api.getFMUState()
    saved = instance.everything()
    onward = instance.run(30, 70)
    instance.api.setFMUState(state)
    assert identical(instance.everything(), saved)
    assert identical(instance.run(30, 70), onward)
    instance.api.freeFMUState(state)


RESUME = """
import importlib.util, pathlib, sys
spec = importlib.util.spec_from_file_location("conformance", sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
for line in sys.stdin:
    path, version, target, state = line.rstrip("\\n").split("\\t")
    slave = module.Slave(module.Fmu(pathlib.Path(path), int(version), target))
    slave.api.setFMUState(slave.api.deserializeFMUState(bytes.fromhex(state)))
    print(slave.run(30, 60).tobytes().hex(), flush=True)
"""
"""Starting takes two seconds, so one other process goes on with the states of all FMUs."""


@pytest.fixture(scope="module")
def other_process():
    command = [sys.executable, "-c", RESUME, Path(__file__).with_name("conftest.py")]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes) as process:
        yield process
        process.stdin.close()


@pytest.mark.slow
def test_a_serialised_state_goes_on_in_another_process(fmu, slave, other_process):
    instance = slave(fmu).initialize(fmu.settings())
    instance.run(0, 30)
    state = instance.api.getFMUState()
    stored = instance.api.serializeFMUState(state).hex()
    instance.api.freeFMUState(state)
    print(fmu.path, fmu.version, fmu.target, stored, sep="\t", file=other_process.stdin, flush=True)
    assert other_process.stdout.readline().strip() == instance.run(30, 60).tobytes().hex()


def test_bytes_of_another_build_are_no_state(some_fmu, slave, build):
    other = build(
        models.model_names()[some_fmu.model.name == models.model_names()[0]], some_fmu.version
    )
    donor = slave(other).initialize()
    state = donor.api.getFMUState()
    foreign = donor.api.serializeFMUState(state)
    donor.api.freeFMUState(state)
    instance = slave(some_fmu).initialize()
    for wrong in (foreign, foreign[:-1], b"\0"):
        with pytest.raises(FMICallException):
            instance.api.deserializeFMUState(wrong)
        assert "not a state of this build" in instance.messages[-1][2]
    instance.run(0, 3)


def test_both_versions_of_the_standard_give_the_same_bits(name, build, slave, identical):
    second, third = build(name, 2), build(name, 3)
    settings = second.settings()
    names = list(second.variables)
    assert ["time", *names] == list(third.variables)  # FMI 2.0 does not ask for it
    runs = [slave(fmu).initialize(settings) for fmu in (second, third)]
    for n in range(100):
        for run in runs:
            run.run(n, n + 1)
        assert identical(*(run.get(names) for run in runs))


def test_a_run_changes_no_parameter(fmu, slave, identical):
    instance = slave(fmu).initialize(fmu.settings())
    parameters = fmu.names("parameter")
    before = instance.get(parameters)
    instance.run(0, 50)
    assert identical(instance.get(parameters), before)


def test_time_is_that_of_the_last_communication_point(name, build, slave):
    instance = slave(build(name, 3)).initialize(start=2.0)
    assert instance.get(["time"]) == [2.0]
    instance.api.doStep(2.0, 0.25)
    assert instance.get(["time"]) == [2.25]


def test_a_description_of_another_build_is_refused(some_fmu, slave):
    messages = []
    with pytest.raises(Exception, match="Failed to instantiate"):
        slave(some_fmu, guid="stale", messages=messages)
    [(status, _, text)] = messages
    assert status == ERROR
    assert "was given stale: modelDescription.xml is of another build" in text
    slave(some_fmu)


def test_events_are_logged_when_asked_for(some_fmu, slave):
    quiet, talking = slave(some_fmu), slave(some_fmu, logging=True)
    for instance in (quiet, talking):
        instance.initialize(start=1.5)
    assert quiet.messages == []
    assert talking.messages == [(0, "logEvents", "initialized at t = 1.5 s")]


@pytest.mark.parametrize(
    ("categories", "heard"),
    [([], True), (["logEvents"], True), (["logAll"], True), (["logStatusError"], False)],
)
def test_categories_choose_what_is_logged(build, version, slave, categories, heard):
    fmu = build("stage", version)
    instance = slave(fmu)
    assert {c.name for c in fmu.description.logCategories} >= set(categories)
    if fmu.version == 2:
        names = (ctypes.c_char_p * len(categories))(*(c.encode() for c in categories))
        instance.api.fmi2SetDebugLogging(instance.api.component, 1, len(categories), names)
    else:
        instance.api.setDebugLogging(True, categories)
    instance.initialize(start=1.5)
    assert [text for *_, text in instance.messages] == ["initialized at t = 1.5 s"] * heard
    _refused(instance, lambda: instance.api.doStep(1.5, -1.0), "must be positive")


def _refused(instance, call, *words):
    """Check that a call answers Error with a message holding these words."""
    count = len(instance.messages)
    with pytest.raises(FMICallException) as refusal:
        call()
    assert refusal.value.status == ERROR
    status, category, text = instance.messages[-1]
    assert (len(instance.messages), status, category) == (count + 1, ERROR, "logStatusError")
    for word in words:
        assert word in text


def test_refused_calls_say_why_and_leave_the_instance_usable(fmu, slave, identical):
    untouched = slave(fmu).initialize().run(0, 30)
    instance = slave(fmu)
    api = instance.api
    real = "Real" if fmu.version == 2 else "Float64"
    last = len(fmu.model.variables) - 1
    setter, getter = getattr(api, f"set{real}"), getattr(api, f"get{real}")
    output = fmu.variables[fmu.names("output")[0]].valueReference
    source = fmu.variables[fmu.names("input")[0]].valueReference
    memory = [fmu.variables[n].valueReference for n in fmu.names("memory")]
    bounded = next(v for v in fmu.model.variables if v.minimum is not None and v.type == "real")
    bound = fmu.variables[bounded.name].valueReference

    _refused(instance, lambda: api.doStep(0.0, 5e-4), "DoStep", "not allowed", "'instantiated'")
    _refused(instance, lambda: api.exitInitializationMode(), "ExitInitializationMode")
    _refused(instance, lambda: api.terminate(), "Terminate")
    _refused(instance, lambda: setter([bound], [bounded.minimum - 1.0]), bounded.name, "outside")
    _refused(instance, lambda: setter([bound], [float("nan")]), bounded.name, "nan")
    _refused(instance, lambda: setter([last + 1], [1.0]), f"reference {last + 1} does not exist")
    _refused(instance, lambda: setter([0], [1.0]), "time cannot be set")
    instance.initialize()
    _refused(instance, lambda: setter([output], [1.0]), "cannot be set")
    for wrong in (float("nan"), float("inf"), float("-inf")):
        _refused(instance, lambda wrong=wrong: setter([source], [wrong]), "outside")
    _refused(instance, lambda: getter([last + 1]), f"reference {last + 1} does not exist")
    for reference in memory:
        _refused(instance, lambda reference=reference: setter([reference], [0.0]), "cannot be set")
    _refused(instance, lambda: api.getBoolean([source]), "another type")
    _refused(instance, lambda: api.setBoolean([source], [True]), "another type")
    _refused(instance, lambda: api.doStep(0.0, 0.0), "must be positive")
    _refused(instance, lambda: api.doStep(0.0, -1e-3), "must be positive")
    _refused(instance, lambda: api.doStep(0.0, float("nan")), "must be positive")
    _refused(instance, lambda: api.enterInitializationMode(), "EnterInitializationMode")
    assert identical(instance.run(0, 30), untouched)
    api.terminate()
    _refused(instance, lambda: api.doStep(30 * 5e-4, 5e-4), "'terminated'")


def test_only_tunable_parameters_change_during_a_run(some_fmu, slave):
    instance = slave(some_fmu).initialize()
    for variable in some_fmu.model.variables:
        if variable.role != "parameter":
            continue
        value = variable.start
        if variable.variability == "tunable":
            instance.set({variable.name: value})
        else:
            _refused(
                instance,
                lambda name=variable.name, value=value: instance.set({name: value}),
                f"{variable.name} cannot be set in phase 'step mode'",
            )


ACTS_LATER = {
    ("adaptive_scale", "rate"),
    ("drive", "pitch"),
    ("drive", "mu_g"),
    ("position_force", "mu_g"),
    ("position_force", "F_c"),
}
"""Parameters without effect in this motion; another test has each of them."""


def test_a_tunable_parameter_acts_from_the_next_step_on(some_fmu, slave, identical):
    unchanged = slave(some_fmu).initialize().run(0, 150)
    for variable in some_fmu.model.variables:
        if (some_fmu.model.name, variable.name) in ACTS_LATER:
            continue
        if variable.role == "parameter" and variable.variability == "tunable":
            instance = slave(some_fmu).initialize()
            before = instance.run(0, 30)
            highest = math.inf if variable.maximum is None else variable.maximum
            other = min(1.5 * variable.start or variable.nominal or 1.0, highest)
            instance.set({variable.name: 0.5 * other if other == variable.start else other})
            after = instance.run(30, 150)
            assert identical(before, unchanged[:30])
            place = {name: k for k, name in enumerate(some_fmu.variables)}
            outputs = [place[name] for name in some_fmu.names("output")]
            assert not identical(after[:, outputs], unchanged[30:, outputs]), variable.name


def test_what_is_not_declared_answers_with_a_message(some_fmu, slave):
    instance = slave(some_fmu).initialize()
    if some_fmu.version == 3:
        _refused(instance, lambda: instance.api.getUInt8([0]), "is not available")
    if not some_fmu.model.is_continuous:
        call = instance.api.getDirectionalDerivative
        _refused(instance, lambda: call([1], [2], [1.0]), "is not available")


def test_the_largest_numbers_are_borne_or_refused_and_reset_heals(fmu, slave, identical):
    instance = slave(fmu).initialize()
    healthy = instance.run(0, 20)
    largest = np.finfo(float).max
    results = fmu.names("state", "memory", "output")
    try:
        for n in range(20, 24):
            instance.set(dict.fromkeys(fmu.names("input"), largest * (-1) ** n))
            instance.api.doStep(n * 5e-4, 5e-4)
            assert np.isfinite(instance.get(results)).all()
    except FMICallException:
        assert "not finite" in instance.messages[-1][2]
        _refused(instance, lambda: instance.api.doStep(1.0, 5e-4), "'failed'")
    instance.api.reset()
    assert identical(instance.initialize().run(0, 20), healthy)
