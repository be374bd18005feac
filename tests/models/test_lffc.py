"""Learning feedforward with B-splines: what it learns, and what it is when it does not."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim

T = 5e-4  # s


def follow(fmus, name, v_r, friction=None, record=(), **parameters):
    """Run it alone; the controller commands what the motion needs, and the friction (n,) [N]."""
    system = cosim.System()
    system.add("fmu", fmus / f"{name}.fmu", {"m": 1.0, "b": 0.0, "lead": 0.0, **parameters})
    friction = np.zeros(len(v_r)) if friction is None else friction
    needed = np.diff(np.append(v_r[0], v_r)) / T
    signals = {"v_r": v_r, "u": np.append(0.0, (needed + friction)[:-1])}
    for signal in signals:
        system.expose(signal, f"fmu.{signal}")
    recorded = ("fmu.F", *record)
    stop = T * (len(v_r) - 1)
    with system.prepare(step=T, stop=stop, constant_step=True, record=recorded) as simulation:
        return simulation.run(inputs=signals)


def weights(result) -> np.ndarray:
    names = [[f"fmu.w[{i},{j}]" for j in range(1, 15)] for i in (1, 2)]
    return np.array([[result[name][-1] for name in row] for row in names])


W = tuple(f"fmu.w[{i},{j}]" for i in (1, 2) for j in range(1, 15))


def test_a_force_that_lacks_is_learned_at_the_rate_gamma(fmus):
    """A controller that always has to add 5 N: one spline alone converges as (1 - gamma)^k."""
    v = np.full(600, 0.05)
    friction = np.full(600, 5.0)
    result = follow(fmus, "lffc", v, friction, W, last=1e-5, first=1e-6, D=0, gamma=0.01)
    found = weights(result)
    # What it commands itself is not taken off this controller: the error stays 5 N - F.
    assert found[0, 13] == pytest.approx(5.0 * (1.0 - 0.99 ** (600 - 3)), rel=0.01)
    np.testing.assert_array_equal(found[1], 0.0)


def test_weights_are_the_force_at_the_knots(fmus):
    """With the rate 0 the force interpolates the weights over the displacement."""
    w = np.random.default_rng(3).normal(0.0, 3.0, (2, 14))
    start = {f"w_0[{i + 1},{j + 1}]": w[i, j] for i in range(2) for j in range(14)}
    v = np.repeat([0.002, -0.001], 1500)
    result = follow(fmus, "lffc", v, None, W, gamma=0.0, **start)
    knots = np.append(0.0, np.geomspace(1e-6, 2e-3, 13))
    k = np.arange(1499)
    expected = np.interp(0.002 * T * (k + 0.5), knots, w[0])
    np.testing.assert_allclose(result["fmu.F"][1:1500], expected, atol=1e-9)
    expected = np.interp(0.001 * T * (k + 0.5), knots, w[1])
    np.testing.assert_allclose(result["fmu.F"][-1498:], expected[:1498], atol=1e-9)
    np.testing.assert_array_equal(weights(result), w)
