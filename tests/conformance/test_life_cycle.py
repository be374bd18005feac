"""Calls that are not allowed, what is logged, tunable parameters and the largest numbers.

Saved states, reset and values are checked by fmucheck (tests/fmucheck) and by random calls.
"""

import ctypes
import math

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

ERROR = 3


@pytest.fixture(params=["stage", "velocity_controller"])
def one_fmu(request, build, version):
    """Give a continuous and a sampled model: what holds here holds for the adapter of all."""
    return build(request.param, version)


def test_a_description_of_another_build_is_refused(one_fmu, slave):
    messages = []
    with pytest.raises(Exception, match="Failed to instantiate"):
        slave(one_fmu, guid="stale", messages=messages)
    [(status, _, text)] = messages
    assert status == ERROR
    assert "was given stale: modelDescription.xml is of another build" in text


def test_events_are_logged_when_asked_for(one_fmu, slave):
    quiet, talking = slave(one_fmu), slave(one_fmu, logging=True)
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


def test_refused_calls_say_why_and_leave_the_instance_usable(one_fmu, slave, identical):
    fmu = one_fmu
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
    for v in fmu.model.variables:
        if v.role == "parameter" and v.variability == "tunable":
            instance.set({v.name: v.start})
        elif v.role == "parameter":
            said = f"{v.name} cannot be set in phase 'step mode'"
            _refused(instance, lambda v=v: instance.set({v.name: v.start}), said)
    if fmu.version == 3:
        _refused(instance, lambda: api.getUInt8([0]), "is not available")
    if not fmu.model.is_continuous:
        slope = api.getDirectionalDerivative
        _refused(instance, lambda: slope([1], [2], [1.0]), "is not available")
    assert identical(instance.run(0, 30), untouched)
    api.terminate()
    _refused(instance, lambda: api.doStep(30 * 5e-4, 5e-4), "'terminated'")


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
