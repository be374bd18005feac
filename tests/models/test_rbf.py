"""Radial basis functions: shares of one, a smooth function, and what one error changes."""

from __future__ import annotations

import numpy as np

from stickslip import cosim

T = 5e-4  # s
W = [(i, j) for i in range(1, 12) for j in range(1, 9)]


def run(fmus, v_r, u, **parameters):
    system = cosim.System()
    system.add("fmu", fmus / "rbf.fmu", {"m": 1e-6, "b": 0.0, **parameters})
    system.expose("v_r", "fmu.v_r")
    system.expose("u", "fmu.u")
    record = ("fmu.F", *(f"fmu.w[{i},{j}]" for i, j in W))
    with system.prepare(step=T, stop=T * (len(v_r) - 1), record=record) as simulation:
        return simulation.run(inputs={"v_r": v_r, "u": u})


def test_equal_weights_are_that_force_everywhere(fmus):
    v = 0.05 * np.sin(np.arange(1000) * 0.02 + 0.01) ** 3
    weights = {f"w_0[{i},{j}]": 4.0 for i, j in W}
    found = run(fmus, v, np.zeros(1000), gamma=0.0, **weights)["fmu.F"]
    np.testing.assert_allclose(found[1:], 4.0, rtol=1e-13)


def test_one_error_moves_the_force_there_by_its_share(fmus):
    """Where the motion stays at one place: the command of a period is seen at its end."""
    v = np.full(400, 0.05)
    lack = 5.0 - run(fmus, v, np.full(400, 5.0), gamma=0.05, D=0, q_0=1e-12)["fmu.F"]
    np.testing.assert_allclose(lack[3:], lack[2:-1] - 0.05 * lack[1:-2], atol=1e-7)
    assert abs(lack[-1]) < 1e-5


def test_a_weight_stays_within_its_limit(fmus):
    result = run(fmus, np.full(400, 0.05), np.full(400, 1e3), gamma=0.5, D=0, F_max=7.0)
    last = [result[f"fmu.w[{i},{j}]"][-1] for i, j in W]
    assert max(last) == 7.0
    assert 5.0 < result["fmu.F"][-1] < 7.0 + 1e-9
