"""Directional and adjoint derivatives: closed forms against complex steps and differences."""

import numpy as np
import pytest

from tests.conformance import equations

CONTINUOUS = list(equations.OF)
pytestmark = [
    pytest.mark.parametrize("version", [2, 3], ids=["fmi2", "fmi3"]),
    pytest.mark.parametrize("name", CONTINUOUS),
]


def unknowns(fmu):
    return fmu.names("derivative", "output")


def knowns(fmu):
    return fmu.names("state", "input")


def references(fmu, names):
    return [fmu.variables[n].valueReference for n in names]


def matrix(instance):
    """Return all partial derivatives, a column for each direction asked for."""
    fmu = instance.fmu
    of, by = references(fmu, unknowns(fmu)), references(fmu, knowns(fmu))
    columns = [instance.api.getDirectionalDerivative(of, [k], [1.0]) for k in by]
    return np.transpose(columns)


def changed(fmu):
    """Return start values other than those of model.toml; a damping that fades."""
    return {"b": 6.0} | ({"v_d": 2.0} if "v_d" in fmu.variables else {})


def moved(instance, point):
    fmu = instance.fmu
    instance.set({n: point[n] for n in fmu.names("input")})
    instance.place(0.0, [point[n] for n in fmu.names("state")])
    return np.array(instance.get(unknowns(fmu)))


@pytest.fixture
def solved(build, exchanged, name, version):
    instance = exchanged(build(name, version))
    instance.initialize(changed(instance.fmu))
    instance.api.enterContinuousTimeMode()
    return instance


def test_they_equal_complex_steps_of_the_equations(solved):
    fmu = solved.fmu
    p = {v.name: v.start for v in fmu.model.variables if v.role == "parameter"} | changed(fmu)
    for point in fmu.points(40):
        moved(solved, point)
        exact = equations.jacobian(fmu.target, point, p)
        expected = [[exact[u][k] for k in knowns(fmu)] for u in unknowns(fmu)]
        np.testing.assert_allclose(matrix(solved), expected, rtol=1e-11, atol=1e-11)


def test_at_rest_they_are_the_mean_of_both_sides(solved):
    fmu = solved.fmu
    states = [v for v in fmu.model.variables if v.role == "state"]
    rest = dict.fromkeys(knowns(fmu), 0.0) | {states[-1].name: states[-1].nominal}
    sides = []
    for v in (1e-13, -1e-13, 0.0):
        moved(solved, rest | {"v": v})
        sides.append(matrix(solved))
    np.testing.assert_allclose(sides[2], (sides[0] + sides[1]) / 2, rtol=1e-8, atol=1e-8)
    assert not np.allclose(sides[0], sides[1])


def test_a_direction_is_a_sum_of_columns_and_the_adjoint_the_transpose(solved):
    fmu = solved.fmu
    of, by = references(fmu, unknowns(fmu)), references(fmu, knowns(fmu))
    seeds = [np.linspace(-1.0, 2.0, len(names)) for names in (by, of)]
    for point in fmu.points(5):
        moved(solved, point)
        found = solved.api.getDirectionalDerivative(of, by, seeds[0].tolist())
        np.testing.assert_allclose(found, matrix(solved) @ seeds[0], rtol=1e-13)
        if fmu.version == 3:  # FMI 2.0 has none
            found = solved.api.getAdjointDerivative(of, by, seeds[1].tolist(), len(by))
            np.testing.assert_allclose(found, matrix(solved).T @ seeds[1], rtol=1e-12)


def test_declared_dependencies_are_the_places_of_the_matrix(solved):
    """None is missing; one of kind constant or fixed is the same everywhere."""
    fmu = solved.fmu
    at = []
    for point in fmu.points(100):
        moved(solved, point)
        at.append(matrix(solved))
    structure = fmu.description.outputs + fmu.description.derivatives
    declared = {u.variable.name: u for u in structure}
    assert set(declared) == set(unknowns(fmu))
    for row, unknown in enumerate(unknowns(fmu)):
        entry = declared[unknown]
        kinds = dict(zip((d.name for d in entry.dependencies), entry.dependenciesKind, strict=True))
        for column, known in enumerate(knowns(fmu)):
            values = {float(m[row, column]) for m in at}
            assert (values != {0.0}) == (known in kinds), (unknown, known)
            if known in kinds:
                assert (len(values) == 1) == (kinds[known] in ("constant", "fixed", "tunable"))


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
