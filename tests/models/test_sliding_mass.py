"""The step of a mass on a LuGre contact: order, accuracy, sub-steps, passivity, stability."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from tests.models.contacts import TABLE_2, contacts

STEP = 5e-4  # s
M, B = 5.557, 6.6135  # kg, N s/m
EVERYWHERE = settings(derandomize=True, deadline=None, max_examples=60, database=None)


def back_and_forth(n: int, amplitude: float = 20.0) -> np.ndarray:
    """Return a force [N] that lets the mass stick, slip and turn."""
    t = np.arange(n) * STEP
    return amplitude * np.sin(2 * np.pi * 2.0 * t) * np.cos(2 * np.pi * 0.31 * t)


def test_the_sub_step_follows_the_cube_root_of_its_error(c):
    """The error is of order 3 in the sub-step; between bounds the next one aims at 0.5 of it."""
    error = np.geomspace(0.004, 100.0, 2001)
    np.testing.assert_allclose(c("step_factor", error), 0.8 * error ** (-1 / 3), rtol=3e-3)
    assert (c("step_factor", np.array([0.0, 1e-300, 0.003])) == 5.0).all()
    assert (c("step_factor", np.array([101.0, 1e300, np.inf])) == 0.15).all()


def test_the_method_is_l_stable(mass_run):
    """One sub-step far longer than the fastest time constant ends near the steady state."""
    stiff = {**TABLE_2, "sigma_0": 1e9}
    end = mass_run("rodas3", 1.0, np.array([6.5]), contact=stiff, start=(0.0, 0.01, 0.0))
    exact = mass_run("adaptive", 1.0, np.array([6.5]), contact=stiff, start=(0.0, 0.01, 0.0))
    assert np.isfinite(end).all()
    assert abs(end[0, 1]) < 0.1
    assert exact[0, 1] > 0.0


@pytest.mark.parametrize(
    "u", [back_and_forth(4000), back_and_forth(4000, 7.5)], ids=["slip", "stick"]
)
def test_sub_steps_follow_their_tolerance(mass_run, u):
    """Sticking, slipping and turning: within 1e-7 m/s and 2e-4 N of a fine Runge-Kutta method."""
    error = abs(mass_run("adaptive", STEP, u) - mass_run("rk4", STEP, u, pieces=200))
    assert error[:, 1].max() < 1e-7
    assert error[:, 2].max() * TABLE_2["sigma_0"] < 2e-4


@EVERYWHERE
@given(
    contact=contacts,
    m=st.floats(-1, 2).map(lambda e: M * 10.0**e),
    b=st.floats(-1, 2).map(lambda e: B * 10.0**e),
    amplitude=st.floats(0, 3).map(lambda e: 10.0**e),
)
def test_every_parameter_vector_stays_within_its_energy(mass_run, contact, m, b, amplitude):
    """0.1 x .. 100 x: finite, and the bristle bends no further than max(F_s, F_c) / sigma_0."""
    u = back_and_forth(400, amplitude)
    motion = mass_run("adaptive", STEP, u, m=m, b=b, contact=contact)
    assert np.isfinite(motion).all()
    reach = max(contact["F_s"], contact["F_c"]) / contact["sigma_0"]
    assert abs(motion[:, 2]).max() <= reach * (1 + 1e-3) + 1e-10
    assert abs(motion[:, 1]).max() <= 400 * STEP * amplitude / m * (1 + 1e-3) + 10 * reach / STEP


def test_the_contact_is_passive_where_theory_says_so(mass_run):
    """sigma_1 |v| < 4 g(v): the force's work less kinetic, bristle and viscous energy never falls.

    With the force held its work over a step is u dx exactly. dD = F_f v - d(sigma_0 z^2 / 2) is a
    quadratic form in (z, v), definite under that condition.
    """
    contact = {**TABLE_2, "sigma_1": 20.0}
    u = back_and_forth(8000)
    motion = np.vstack([np.zeros(3), mass_run("adaptive", STEP, u, contact=contact)])
    x, v, z = motion.T
    assert (contact["sigma_1"] * abs(v) < 4 * contact["F_c"]).all()
    stored = 0.5 * M * v**2 + 0.5 * contact["sigma_0"] * z**2
    lost = u * np.diff(x) - np.diff(stored)
    assert lost.min() > -1e-9  # J
    assert lost.sum() > 0.1


def rates(y: np.ndarray, u: float) -> np.ndarray:
    """Equations (1) to (3) of the paper for y = (v, z) at v > 0."""
    p, (v, z) = TABLE_2, y
    g = p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-v / p["v_s"])
    dz = v - p["sigma_0"] * v / g * z
    return np.array([(u - B * v - p["sigma_0"] * z - p["sigma_1"] * dz) / M, dz])


def estimated_error(h: float, y: np.ndarray, u: float) -> float:
    """Return the local error of Rodas3 in tolerances, from the coefficients of its publication.

    The embedded method differs by its last stage. Allowed are 1e-6 of the motion, 1e-8 m/s and
    1e-5 N of bristle force, as models/plants/stage/README.md has it.
    """
    a = np.array([[0, 0, 0], [0, 0, 0], [2, 0, 0], [2, 0, 1]])
    c = np.array([[0, 0, 0], [4, 0, 0], [1, -1, 0], [1, -1, -8 / 3]]) / h
    tiny = 1e-7 * np.diag([1e-2, 1e-5])
    jacobian = np.column_stack([(rates(y + e, u) - rates(y - e, u)) / (2 * e.sum()) for e in tiny])
    matrix = 2.0 / h * np.eye(2) - jacobian
    k = np.zeros((4, 2))
    for i in range(4):
        k[i] = np.linalg.solve(matrix, rates(y + a[i] @ k[:3], u) + c[i] @ k[:3])
    v, z = abs(y + np.array([2, 0, 1, 1]) @ k)
    force = TABLE_2["sigma_0"]
    return max(abs(k[3, 0]) / (1e-8 + 1e-6 * v), force * abs(k[3, 1]) / (1e-5 + 1e-6 * force * z))


@pytest.mark.parametrize("v", [1e-3, 0.02, 1.0])
@pytest.mark.parametrize("force", [0.0, 4.0], ids="bristle at {} N".format)
def test_a_step_is_one_piece_just_when_its_error_is_allowed(mass_run, v, force):
    y, u = np.array([v, force / TABLE_2["sigma_0"]]), 20.0
    longest = brentq(lambda h: estimated_error(h, y, u) - 1.0, 1e-8, 1e-2, xtol=1e-12)
    for h, allowed in ((0.99 * longest, True), (1.01 * longest, False)):
        assert (estimated_error(h, y, u) <= 1.0) == allowed
        step, one_piece = (
            mass_run(method, h, np.array([u]), start=(0.0, *y)) for method in ("adaptive", "rodas3")
        )
        assert np.array_equal(step, one_piece) == allowed


@pytest.mark.slow
def test_a_step_of_more_than_ten_million_pieces_is_given_up(mass_run):
    """A mass that swings on bristles without loss needs two million pieces a second."""
    swing = {"F_s": 1e9, "F_c": 1e9, "v_s": 1e-3, "sigma_0": 1e9, "sigma_1": 0.0}
    for seconds, done in ((4.0, True), (10.0, False)):
        _, v, z = mass_run(
            "adaptive", seconds, np.zeros(1), m=1.0, b=0.0, contact=swing, start=(0.0, 0.1, 0.0)
        )[0]
        assert np.isfinite(v) == done
        assert not done or 0.5 * 0.1**2 < v**2 + swing["sigma_0"] * z**2 <= 0.1**2
