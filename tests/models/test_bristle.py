"""The LuGre bristle: equations (2) to (4) and the exact step at constant velocity."""

from __future__ import annotations

import ctypes
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.models.contacts import TABLE_2, contacts

EVERYWHERE = settings(derandomize=True, deadline=None, max_examples=200, database=None)

velocities = st.floats(-6.0, 0.0).flatmap(lambda e: st.sampled_from([10.0**e, -(10.0**e)]))
steps = st.floats(-5.0, -2.0).map(lambda e: 10.0**e)  # 1e-5 .. 1e-2 s


@pytest.fixture
def g(library: ctypes.CDLL):
    library.probe_g.restype = ctypes.c_double

    def g(v: float, delta: float = 1.0, contact: dict[str, float] = TABLE_2) -> tuple[float, float]:
        slope = ctypes.c_double()
        p = (ctypes.c_double * 6)(*contact.values(), delta)
        return library.probe_g(ctypes.c_double(v), p, ctypes.byref(slope)), slope.value

    return g


def equation_4(v: float, p: dict[str, float], delta: float = 1.0) -> float:
    return p["F_c"] + (p["F_s"] - p["F_c"]) * math.exp(-((abs(v) / p["v_s"]) ** delta))


@pytest.mark.parametrize("delta", [0.5, 1.0, 1.7, 2.0])
def test_stribeck_curve_is_equation_4(g, delta):
    for v in (1e-7, -1e-5, 5.5697e-4, -2e-3, 0.04):
        assert g(v, delta)[0] == pytest.approx(equation_4(v, TABLE_2, delta), rel=1e-14)


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 9.9, 10.0, 1e4, 1e18])
def test_stribeck_curve_far_above_its_velocity(g, ratio):
    """e^-40 is nothing beside 1, but not where the stick force is far above Coulomb's."""
    contact = {**TABLE_2, "F_s": 1e-9 * ratio, "F_c": 1e-9}
    for exponent in (30.0, 39.9, 40.1, 60.0, 90.0):
        v = exponent * contact["v_s"]
        assert g(v, 1.0, contact)[0] == pytest.approx(equation_4(v, contact), rel=3e-14, abs=0)


def test_stribeck_curve_runs_from_stick_to_coulomb_force(g):
    assert g(0.0)[0] == pytest.approx(8.999, rel=1e-15)
    assert g(1.0)[0] == pytest.approx(5.999, rel=1e-15)
    values = [g(v)[0] for v in np.linspace(0, 5e-3, 50)]
    assert (np.diff(values) < 0).all()
    assert g(-1e-3) == g(1e-3)


@pytest.mark.parametrize("delta", [0.5, 1.0, 2.0])
def test_slope_is_the_derivative_times_speed(g, delta):
    v, d = 4e-4, 1e-9
    numeric = v * (g(v + d, delta)[0] - g(v - d, delta)[0]) / (2 * d)
    assert g(v, delta)[1] == pytest.approx(numeric, rel=1e-5)


@pytest.mark.slow
@EVERYWHERE
@given(p=contacts, v=velocities, h=steps, start=st.floats(-2.0, 2.0))
def test_step_is_the_closed_form(lugre, p, v, h, start):
    """z(t) = z_inf + (z - z_inf) e^(-a t); the force is the mean of (3) over the step."""
    z_inf = math.copysign(equation_4(v, p) / p["sigma_0"], v)
    z = start * z_inf
    y = abs(v) * h / abs(z_inf)  # a h
    after, force = lugre(h, v, z, p)
    gone = -math.expm1(-y)
    assert after == pytest.approx(z + (z_inf - z) * gone, rel=1e-12, abs=1e-12 * abs(z_inf))
    mean_z = z_inf + (z - z_inf) * gone / y
    expected = p["sigma_0"] * mean_z + p["sigma_1"] * (z_inf - z) * gone / h
    scale = p["sigma_0"] * abs(z_inf) + p["sigma_1"] * abs(v)
    assert force == pytest.approx(expected, rel=1e-8, abs=1e-8 * scale)


def test_standing_still_keeps_the_deflection(lugre):
    assert lugre(1e-3, 0.0, 1e-5, TABLE_2) == (1e-5, pytest.approx(3.9162e5 * 1e-5, rel=1e-15))
