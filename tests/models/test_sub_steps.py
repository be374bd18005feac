"""Which sub-steps the step of a mass on a contact accepts, and when it gives up."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.models.contacts import TABLE_2

M, B = 5.557, 6.6135  # kg, N s/m


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
