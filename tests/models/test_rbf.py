"""Radial basis functions: shares of one, a smooth function, and what one error changes."""

from __future__ import annotations

import numpy as np

T = 5e-4  # s
W = [(i, j) for i in range(1, 12) for j in range(1, 9)]


def test_equal_weights_are_that_force_everywhere(network):
    v = 0.05 * np.sin(np.arange(1000) * 0.02 + 0.01) ** 3
    weights = {f"w_0[{i},{j}]": 4.0 for i, j in W}
    found = network("rbf", v, np.zeros(1000), gamma=0.0, **weights)["fmu.F"]
    np.testing.assert_allclose(found[1:], 4.0, rtol=1e-13)


def test_one_error_moves_the_force_there_by_its_share(network):
    """Where the motion stays at one place: the command of a period is seen at its end."""
    v = np.full(400, 0.05)
    lack = 5.0 - network("rbf", v, np.full(400, 5.0), gamma=0.05, D=0, q_0=1e-12)["fmu.F"]
    np.testing.assert_allclose(lack[3:], lack[2:-1] - 0.05 * lack[1:-2], atol=1e-7)
    assert abs(lack[-1]) < 1e-5


def test_a_weight_stays_within_its_limit(network):
    result = network("rbf", np.full(400, 0.05), np.full(400, 1e3), gamma=0.5, D=0, F_max=7.0)
    last = [result[f"fmu.w[{i},{j}]"][-1] for i, j in W]
    assert max(last) == 7.0
    assert 5.0 < result["fmu.F"][-1] < 7.0 + 1e-9
