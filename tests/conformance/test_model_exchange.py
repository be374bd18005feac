"""Model Exchange: the equations of the paper, their derivatives, the samples of Co-Simulation.

Directional and adjoint derivatives are compared with complex steps and differences.
"""

import numpy as np
import pytest

from stickslip import models
from tests.conformance import equations

CONTINUOUS = list(equations.OF)
SWITCHED = ("coulomb_stribeck", "gms", "leuven")
UNKNOWNS, KNOWNS = ("derivative", "output"), ("state", "input")
each_law = pytest.mark.parametrize("name", CONTINUOUS)
SAMPLED = [name for name in models.model_names() if models.load_model(name).sampled]


def parameters(fmu):
    return {v.name: v.start for v in fmu.model.variables if v.role == "parameter"}


def at(instance, point):
    """Put the model to a point and return derivatives and outputs by name."""
    fmu = instance.fmu
    instance.set({n: point[n] for n in fmu.names("input")})
    instance.place(0.0, [point[n] for n in fmu.names("state")])
    names = fmu.names(*UNKNOWNS)
    return dict(zip(names, instance.get(names), strict=True))


def test_every_law_with_derivatives_is_compared_with_its_equations(name, build):
    model = build(name, 2).model
    switched = name in [f"stage+{law}" for law in SWITCHED]
    assert model.is_continuous == (name in CONTINUOUS or switched)
    assert model.is_switched == switched


@each_law
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
        solved.updated()  # the tool may go on updating
        due = solved.updated()["time"]
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


def references(fmu, names):
    return [fmu.variables[n].valueReference for n in names]


def matrix(instance):
    """Return all partial derivatives, a column for each direction asked for."""
    fmu = instance.fmu
    of, by = (references(fmu, fmu.names(*roles)) for roles in (UNKNOWNS, KNOWNS))
    columns = [instance.api.getDirectionalDerivative(of, [k], [1.0]) for k in by]
    return np.transpose(columns)


def changed(fmu):
    """Return start values other than those of model.toml; a damping that fades."""
    return {"b": 6.0} | ({"v_d": 2.0} if "v_d" in fmu.variables else {})


@pytest.fixture
def solved(build, exchanged, name, version):
    instance = exchanged(build(name, version))
    instance.initialize(changed(instance.fmu))
    instance.api.enterContinuousTimeMode()
    return instance


@each_law
def test_they_equal_complex_steps_of_the_equations(solved):
    fmu = solved.fmu
    p = {v.name: v.start for v in fmu.model.variables if v.role == "parameter"} | changed(fmu)
    for point in fmu.points(40):
        at(solved, point)
        exact = equations.jacobian(fmu.target, point, p)
        expected = [[exact[u][k] for k in fmu.names(*KNOWNS)] for u in fmu.names(*UNKNOWNS)]
        np.testing.assert_allclose(matrix(solved), expected, rtol=1e-11, atol=1e-11)


@each_law
def test_at_rest_they_are_the_mean_of_both_sides(solved):
    fmu = solved.fmu
    states = [v for v in fmu.model.variables if v.role == "state"]
    rest = dict.fromkeys(fmu.names(*KNOWNS), 0.0) | {states[-1].name: states[-1].nominal}
    sides = []
    for v in (1e-13, -1e-13, 0.0):
        at(solved, rest | {"v": v})
        sides.append(matrix(solved))
    np.testing.assert_allclose(sides[2], (sides[0] + sides[1]) / 2, rtol=1e-8, atol=1e-8)
    assert not np.allclose(sides[0], sides[1])


@each_law
def test_a_direction_is_a_sum_of_columns_and_the_adjoint_the_transpose(solved):
    fmu = solved.fmu
    of, by = (references(fmu, fmu.names(*roles)) for roles in (UNKNOWNS, KNOWNS))
    seeds = [np.linspace(-1.0, 2.0, len(names)) for names in (by, of)]
    for point in fmu.points(5):
        at(solved, point)
        found = solved.api.getDirectionalDerivative(of, by, seeds[0].tolist())
        np.testing.assert_allclose(found, matrix(solved) @ seeds[0], rtol=1e-13)
        if fmu.version == 3:  # FMI 2.0 has none
            found = solved.api.getAdjointDerivative(of, by, seeds[1].tolist(), len(by))
            np.testing.assert_allclose(found, matrix(solved).T @ seeds[1], rtol=1e-12)


@each_law
def test_declared_dependencies_are_the_places_of_the_matrix(solved):
    """None is missing; one of kind constant or fixed is the same everywhere."""
    fmu = solved.fmu
    seen = []
    for point in fmu.points(100):
        at(solved, point)
        seen.append(matrix(solved))
    structure = fmu.description.outputs + fmu.description.derivatives
    declared = {u.variable.name: u for u in structure}
    assert set(declared) == set(fmu.names(*UNKNOWNS))
    for row, unknown in enumerate(fmu.names(*UNKNOWNS)):
        entry = declared[unknown]
        kinds = dict(zip((d.name for d in entry.dependencies), entry.dependenciesKind, strict=True))
        for column, known in enumerate(fmu.names(*KNOWNS)):
            values = {float(m[row, column]) for m in seen}
            assert (values != {0.0}) == (known in kinds), (unknown, known)
            if known in kinds:
                assert (len(values) == 1) == (kinds[known] in ("constant", "fixed", "tunable"))


@each_law
def test_in_co_simulation_they_are_those_of_the_outputs_now(build, slave, name, version):
    """What a step has left, such as a mean over it, does not feel an input before the next."""
    fmu = build(name, version)
    instance = slave(fmu).initialize(
        {"b": 6.0} | ({"lead": 1e-3} if name.startswith("compensator") else {})
    )
    outputs = fmu.names("output")
    for n in range(20):
        instance.run(n, n + 1)
        base = fmu.inputs(n)
        for known in fmu.names("input"):
            h = 1e-6 * abs(base[known]) or 1e-9
            sides = []
            for sign in (1, -1):
                instance.set({known: base[known] + sign * h})
                sides.append(np.array(instance.get(outputs)))
            instance.set(base)
            expected = (sides[0] - sides[1]) / (2 * h)
            of, by = references(fmu, outputs), references(fmu, [known])
            found = instance.api.getDirectionalDerivative(of, by, [1.0])
            np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)
