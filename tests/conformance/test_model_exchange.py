"""Model Exchange: the equations of the paper, and the samples of Co-Simulation."""

import pytest

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
