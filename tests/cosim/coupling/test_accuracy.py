"""Every coupling converges as fast as it declares, on two masses whose motion is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from stickslip import cosim

METHODS = ["jacobi", "gauss_seidel", "iterative"]


def motion(pair, time, start):
    """Return place and speed of both masses, (n, 4)."""
    step = expm(pair.matrix * (time[1] - time[0]))
    states = [np.asarray(start)]
    for _ in time[1:]:
        states.append(step @ states[-1])
    return np.array(states)


def run(pair, linear, step, coupling, *, stop=1.0, version=2, **abilities):
    """Return the greatest error of the left mass, m, and the declared order."""
    system = pair.system(linear, version, **abilities)
    with system.prepare(step=step, stop=stop, coupling=coupling) as simulation:
        result = simulation.run()
    start = [1.0, 0.0, pair.right.get("x1", 0.0), 0.0]
    exact = motion(pair, result.time, start)
    return np.abs(result["left.y1"] - exact[:, 0]).max(), simulation.accuracy


@pytest.mark.parametrize("version", [2, 3], ids=["FMI 2.0", "FMI 3.0"])
@pytest.mark.parametrize("interpolates", [True, False])
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("method", METHODS)
def test_measured_order_is_the_declared_one(
    two_masses, linear, method, degree, interpolates, version
):
    coupling = cosim.Coupling(method, degree=degree)
    errors = []
    for step in (2e-3, 1e-3):
        error, order = run(
            two_masses, linear, step, coupling, version=version, interpolates=interpolates
        )
        errors.append(error)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.12)


def test_declared_orders(two_masses, linear):
    def declared(degree, **abilities):
        coupling = cosim.Coupling("iterative", degree=degree)
        return run(two_masses, linear, 0.1, coupling, **abilities)[1]

    assert [declared(degree) for degree in (0, 1, 2)] == [1, 2, 3]
    assert [declared(degree, interpolates=False) for degree in (0, 1, 2)] == [1, 2, 2]


def test_the_best_is_far_more_accurate_than_gauss_seidel(two_masses, linear):
    plain, _ = run(two_masses, linear, 1e-3, "gauss_seidel")
    default, _ = run(two_masses, linear, 1e-3, "iterative")
    best, _ = run(two_masses, linear, 1e-3, cosim.Coupling("iterative", degree=2))
    assert default < plain / 200
    assert best < plain / 20_000


@pytest.mark.parametrize("interpolates", [True, False])
def test_iteration_keeps_a_stiff_pair_stable_where_the_others_blow_up(
    stiff_pair, linear, interpolates
):
    def error(coupling):
        step = 2e-3
        return run(stiff_pair, linear, step, coupling, stop=2.0, interpolates=interpolates)[0]

    assert error("jacobi") > 1e3
    assert error("gauss_seidel") > 1e3
    assert error("iterative") < (0.02 if interpolates else 0.3)
