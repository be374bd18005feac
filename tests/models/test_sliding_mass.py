"""The step of a mass on a LuGre contact: sub-steps, passivity, limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from stickslip import cosim
from tests.cosim.single import exposed

TABLE_2 = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4.4248e3}
"""The paper's."""

_factor = st.floats(-1.0, 2.0).map(lambda e: 10.0**e)
contacts = st.fixed_dictionaries(dict.fromkeys(TABLE_2, _factor)).map(
    lambda factors: {name: factors[name] * value for name, value in TABLE_2.items()}
)
"""Those of 0.1 to 100 times its parameters."""

STEP = 5e-4  # s
M, B = 5.557, 6.6135  # kg, N s/m
EVERYWHERE = settings(derandomize=True, deadline=None, max_examples=60, database=None)


def back_and_forth(n: int, amplitude: float = 20.0) -> np.ndarray:
    """Return a force [N] that lets the mass stick, slip and turn."""
    t = np.arange(n) * STEP
    return amplitude * np.sin(2 * np.pi * 2.0 * t) * np.cos(2 * np.pi * 0.31 * t)


@pytest.fixture(scope="module")
def mass_run(fmus):
    """Move the stage under a force [N] that holds for h seconds each; return x, v, z (n, 3).

    With ``dt`` the length of the sub-step that is tried next [s] is a fourth column.
    """

    def run(h, u, contact=TABLE_2, *, dt=False, **values):
        system = exposed(fmus / "stage.fmu", {"m": M, "b": B, **contact, **values}, "stage")
        names = [f"stage.{name}" for name in ("x", "v", "z", "dt")[: 3 + dt]]
        options = {"step": h, "stop": h * len(u), "record": names, "constant_step": True}
        with system.prepare(**options) as simulation:
            result = simulation.run(inputs={"u": np.append(u, u[-1])})
        return np.column_stack([result[name][1:] for name in names])

    return run


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
    motion = mass_run(STEP, u, contact, m=m, b=b)
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
    motion = np.vstack([np.zeros(3), mass_run(STEP, u, contact)])
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
def test_a_step_is_divided_just_when_its_error_is_not_allowed(mass_run, v, force):
    """And the next sub-step follows the cube root of the error, which is of order 3 in it."""
    y, u = np.array([v, force / TABLE_2["sigma_0"]]), 20.0
    longest = brentq(lambda h: estimated_error(h, y, u) - 1.0, 1e-8, 1e-2, xtol=1e-12)

    def next_step(h):
        return mass_run(h, np.array([u]), v=v, z=y[1], dt=True)[0, 3] / h

    for part in (0.05, 0.2, 0.4, 0.7):
        factor = 0.8 * estimated_error(part * longest, y, u) ** (-1 / 3)
        assert next_step(part * longest) == pytest.approx(min(factor, 5.0), rel=4e-3)
    assert next_step(0.95 * longest) == 1.0  # in one piece
    assert next_step(1.1 * longest) != 1.0


@pytest.mark.thorough
@pytest.mark.slow
def test_a_step_of_more_than_ten_million_pieces_is_given_up(mass_run):
    """A mass that swings on bristles without loss needs two million pieces a second."""
    swing = {"F_s": 1e9, "F_c": 1e9, "v_s": 1e-3, "sigma_0": 1e9, "sigma_1": 0.0}
    of = {"m": 1.0, "b": 0.0, "v": 0.1}
    _, v, z = mass_run(4.0, np.zeros(1), swing, **of)[0]
    assert 0.5 * 0.1**2 < v**2 + swing["sigma_0"] * z**2 <= 0.1**2
    with pytest.raises(cosim.SimulationError, match="the step is too long"):
        mass_run(10.0, np.zeros(1), swing, **of)
