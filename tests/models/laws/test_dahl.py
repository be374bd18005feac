"""Dahl's law with any exponent."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

SIGMA_0, F_C = 3.9162e5, 5.999
H = 5e-4  # s


@pytest.mark.parametrize("i", [0.0, 0.5, 0.999999, 1.000001, 1.5, 2.0])
@pytest.mark.parametrize("v", [1e-9, 1e-5, 1e-3])
def test_any_exponent_against_a_solver(follow, i, v):
    """From a force against the motion, over ways from far below to far above F_c / sigma_0."""
    start, steps = -3.0, 60

    def rate(_: float, F: np.ndarray) -> np.ndarray:
        r = 1.0 - F / F_C
        return SIGMA_0 * np.where(r > 0.0, np.abs(r) ** i, 0.0)

    ways = np.arange(steps + 1) * H * v
    tight = {"rtol": 1e-11, "atol": 1e-12, "max_step": ways[-1] / 2000}
    exact = solve_ivp(rate, (0.0, ways[-1]), [start], "LSODA", dense_output=True, **tight)
    found = follow("dahl", H, np.full(steps, v), i=i, F_d=start)
    tolerance = 2e-5 if i < 1.0 else 1e-7  # the solver's, at the kink where the force is F_c
    np.testing.assert_allclose(found["F_f"], exact.sol(ways)[0], atol=tolerance)
    for k in (0, 20, 59):
        mean, _ = quad(lambda x: float(exact.sol(x)[0]), ways[k], ways[k + 1], limit=50)
        assert found["F_mean"][k] == pytest.approx(mean / (H * v), abs=tolerance)
