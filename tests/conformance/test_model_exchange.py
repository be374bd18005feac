"""Model Exchange: the equations of the paper, and the results of Co-Simulation."""

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from stickslip import models
from tests.conformance import equations

CONTINUOUS = list(equations.OF)
SWITCHED = ("coulomb_stribeck", "gms", "leuven")
SAMPLED = [name for name in models.model_names() if models.load_model(name).sampled]


def parameters(fmu):
    return {v.name: v.start for v in fmu.model.variables if v.role == "parameter"}


def at(instance, point):
    """Put the model to a point and return derivatives and outputs by name."""
    fmu = instance.fmu
    instance.set({n: point[n] for n in fmu.names("input")})
    instance.place(0.0, [point[n] for n in fmu.names("state")])
    names = fmu.names("derivative", "output")
    return dict(zip(names, instance.get(names), strict=True))


def held(time, **signals):
    """Return inputs for FMPy that hold: each change is an event, with two rows."""
    rows = [(t, *row) for row, t in _twice(time, zip(*signals.values(), strict=True))]
    return np.array(rows, dtype=[("time", "f8"), *((name, "f8") for name in signals)])


def _twice(time, rows):
    for k, row in enumerate(rows):
        yield from ((row, t) for t in time[k : k + 2])


def solve(fmu, inputs, **options):
    """Let FMPy's CVode integrate; return one row a time, at an event what was there before."""
    result = fmpy.simulate_fmu(
        str(fmu.path),
        fmi_type="ModelExchange",
        stop_time=inputs["time"][-1],
        relative_tolerance=1e-9,
        input=inputs,
        **options,
    )
    return result[np.unique(result["time"].round(9), return_index=True)[1]]


def test_every_law_with_derivatives_is_compared_with_its_equations(name, build):
    model = build(name, 2).model
    switched = name in [f"stage+{law}" for law in SWITCHED]
    assert model.is_continuous == (name in CONTINUOUS or switched)
    assert model.is_switched == switched


@pytest.mark.parametrize("name", CONTINUOUS)
def test_derivatives_and_outputs_are_the_equations_of_the_paper(build, exchanged, name, version):
    fmu = build(name, version)
    instance = exchanged(fmu).initialize()
    instance.api.enterContinuousTimeMode()
    for point in fmu.points(40):
        found, expected = at(instance, point), equations.OF[name](point, parameters(fmu))
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-12)
        derivatives = [found[n] for n in fmu.names("derivative")]
        assert instance.vector("Derivatives").tolist() == derivatives
        states = [point[n] for n in fmu.names("state")]
        assert instance.vector("ContinuousStates").tolist() == states


@pytest.mark.parametrize(
    ("name", "tolerance"), [("stage", 2e-6), ("compensator", 1e-6), ("compensator+dahl", 1e-6)]
)
def test_the_results_are_those_of_co_simulation(build, name, version, tolerance):
    """Where the input holds over each step; relative to the largest value."""
    fmu = build(name, version)
    [fed] = fmu.names("input")
    step, count = 1e-2, 60
    time = np.arange(count + 1) * step
    values = fmu.sizes()[fed] * 1.5 * np.sin(2 * np.pi * 4.0 * time + 0.5)
    states = fmu.names("state")
    stepped = fmu.simulate(time[-1], step, input={"time": time, fed: values}, output=states)
    solved = solve(fmu, held(time, **{fed: values}), output=states, output_interval=step)
    assert len(solved) == count + 1
    for state in states:
        largest = np.abs(stepped[state]).max()
        np.testing.assert_allclose(
            solved[state] / largest, stepped[state] / largest, atol=tolerance
        )


@pytest.mark.parametrize("name", SAMPLED)
def test_samples_are_time_events_with_the_bits_of_co_simulation(
    build, slave, exchanged, identical, name, version
):
    """What is there just before an event is what Co-Simulation shows at that time."""
    fmu = build(name, version)
    stepping, solved = slave(fmu).initialize(), exchanged(fmu).initialize()
    outputs = fmu.names("output")
    period = 5e-4
    for n in range(80):
        stepping.set(fmu.inputs(n))
        stepping.api.doStep(n * period, period)
        solved.set(fmu.inputs(n))
        solved.update()  # the tool may go on updating
        due = solved.update()
        assert due == pytest.approx((n + 1) * period, rel=1e-12)
        solved.api.enterContinuousTimeMode()
        assert identical(solved.get(outputs), stepping.get(outputs))
        solved.set(fmu.inputs(n + 7))  # between samples nothing answers
        solved.api.setTime(due)
        assert identical(solved.get(outputs), stepping.get(outputs))
        solved.api.enterEventMode()


def test_what_has_no_such_equations_says_so(build, exchanged):
    for version in (2, 3):
        fmu = build("drive", version)
        assert fmu.description.modelExchange is None
        messages = []
        with pytest.raises(Exception, match="Failed to instantiate"):
            exchanged(fmu, messages=messages)
        assert "Model Exchange is not available" in messages[0][2]


@pytest.mark.parametrize("name", CONTINUOUS)
def test_calls_out_of_place_are_refused(build, exchanged, name, version):
    instance = exchanged(build(name, version)).initialize()
    states = np.zeros(instance.n_states)
    with pytest.raises(FMICallException):
        instance.place(0.0, states)
    assert "'event mode'" in instance.messages[-1][2]
    instance.api.enterContinuousTimeMode()
    with pytest.raises(FMICallException):
        instance.update()
    with pytest.raises(FMICallException) as discard:
        instance.place(0.0, states + np.inf)
    assert discard.value.status == 2  # a smaller step may help
    tunable = next(v.name for v in instance.fmu.model.variables if v.variability == "tunable")
    with pytest.raises(FMICallException):
        instance.set({tunable: 1.0})
    instance.place(0.0, states)
    instance.api.enterEventMode()
    instance.set({tunable: 1.0})
    instance.api.terminate()
