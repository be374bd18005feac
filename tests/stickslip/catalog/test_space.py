"""The coordinates of an estimation: inverses, derivatives, bounds and priors, for any law."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip
from stickslip import models
from stickslip.catalog.parameters import (
    DRIVE,
    ParameterSpace,
    estimated,
    force_and_length_of,
    friction_law,
    unit_of,
)
from stickslip.models.export.units import DISPLAY, base_unit, force_and_length

VALUES = {
    "F_s": 9.0, "F_c": 6.0, "v_s": 5e-4, "sigma_0": 4e5, "sigma_1": 4e3,
    "m": 5.5, "b": 6.6, "F_0": -0.3, "delay": 1e-4, "delta": 1.0,
}  # fmt: skip


@pytest.fixture
def space():
    space = ParameterSpace.of(friction_law())
    units = [100.0 if name == "b" else 6.0 if name == "F_0" else 5e-4 for name in space.names]
    return replace(space, units=np.array(units))


def test_decode_is_the_inverse_of_encode_and_the_jacobian_is_its_derivative(space):
    q = space.encode(VALUES)
    assert space.decode(q) == pytest.approx(VALUES, rel=1e-12)
    for index in range(len(q)):
        step = np.zeros(len(q))
        step[index] = 1e-6
        high, low = space.decode(q + step), space.decode(q - step)
        slope = np.array([(high[name] - low[name]) / 2e-6 for name in space.names])
        np.testing.assert_allclose(space.jacobian(q)[:, index], slope, rtol=1e-6, atol=1e-6)
    for name in space.friction:
        gradient = space.jacobian(q)[space.index(name)] / VALUES[name]
        np.testing.assert_allclose(space.direction(name), gradient, rtol=1e-12)


def test_static_friction_is_not_below_coulomb_friction_and_in_a_level_space_equal(space):
    level = space.level()
    assert (level.is_level, space.is_level) == (True, False)
    for one, F_s in ((space, 3.0), (level, VALUES["F_s"])):
        values = one.decode(one.encode({**VALUES, "F_s": F_s}))
        assert values["F_s"] == values["F_c"]


def test_a_fixed_parameter_is_a_constant(space):
    fixed = space.fixed(F_c=7.0, delta=2.0)
    assert fixed.names == tuple(name for name in space.names if name != "F_c")
    expected = {**VALUES, "F_c": 7.0, "delta": 2.0}
    q = fixed.encode(expected)
    assert fixed.decode(q) == pytest.approx(expected, rel=1e-12)
    assert fixed.jacobian(q).shape == (len(q), len(q))
    with pytest.raises(KeyError, match="sigma_2"):
        space.fixed(sigma_2=0.0)


def test_prior_residuals_count_standard_deviations(space):
    deviation = np.full(len(space.names), np.inf)
    deviation[space.index("v_s")] = 0.5
    prior = replace(space, prior_mean=space.encode(VALUES), prior_deviation=deviation)
    assert prior.prior_residual(space.encode({**VALUES, "m": 9.0})).tolist() == [0.0]
    (moved,) = prior.prior_residual(space.encode({**VALUES, "v_s": 1e-3}))
    assert moved == pytest.approx(2.0 * np.log(2.0))


UNITS = {"m": "kg kg.m2", "b": "N.s/m N.m.s/rad", "v_s": "m/s rad/s", "F_c": "N N.m"}
EXPONENTS = {
    "m": (1, -1), "b": (1, -1), "v_s": (0, 1), "F_c": (1, 0), "F_0": (1, 0), "delay": (0, 0),
    "sigma_0": (1, -1), "K_p": (1, -1), "K_i": (1, -1), "I_x": (1, -1), "u_max": (1, 0),
    "tau_f": (0, 0), "no_gain": (0, 0),
}  # fmt: skip


def test_units_and_the_exponents_of_parameters_and_gains():
    assert {name: f"{unit_of(name)} {unit_of(name, rotary=True)}" for name in UNITS} == UNITS
    assert {name: force_and_length_of(name) for name in EXPONENTS} == EXPONENTS
    for one in DRIVE.values():
        assert (one.force, one.length) == force_and_length(one.unit)


@pytest.mark.parametrize("law", models.law_names())
@pytest.mark.parametrize(("force", "length"), [(1e-10, 1e-4), (1e-3, 1e4), (1e6, 10.0)])
def test_a_drive_of_any_size_is_in_range(law, force, length):
    """A micro-actuator of nN and um/s, a fast motor of mN m and 1000 rad/s, and a press of MN."""
    for name in ("drive", "compensator"):
        model = models.load_model(name, law)
        of_size = {
            one.name: one.start
            * force ** force_and_length(one.unit)[0]
            * length ** force_and_length(one.unit)[1]
            for one in model.variables
            if one.role == "parameter" and one.type == "real"
        }
        assert model.with_start(of_size)


@pytest.mark.parametrize("name", models.model_names())
def test_units_of_a_rotary_drive_are_those_of_its_motion(name):
    """A torque is a force times a metre per radian, whatever the exponents of time."""
    linear = models.load_model(name)
    assert linear.of_motion(rotary=False) == linear
    for one, rotary in zip(linear.variables, linear.of_motion(rotary=True).variables, strict=True):
        if one.unit is None:
            continue
        base, of = base_unit(one.unit), base_unit(rotary.unit)
        mass, length = base.get("kg", 0), base.get("m", 0)
        radians = length - mass if one.unit != "kg" else 0
        expected = {"kg": mass, "m": 2 * mass, "s": base.get("s", 0), "rad": radians}
        assert of == {unit: power for unit, power in expected.items() if power}
        assert (rotary.display in DISPLAY[rotary.unit]) if one.display else rotary.display is None


def test_no_module_outside_the_catalog_lists_the_parameters_of_lugre():
    """Four of the five names in one list, tuple or set would be a second law.toml."""
    root = Path(stickslip.__file__).parent
    names = set(estimated(friction_law("lugre")))
    lists = [
        f"{path.relative_to(root)}:{node.lineno}"
        for path in root.rglob("*.py")
        if path.parent.name != "catalog"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.List | ast.Tuple | ast.Set)
        and len(names & {getattr(element, "value", None) for element in node.elts}) >= 4
    ]
    assert not lists
