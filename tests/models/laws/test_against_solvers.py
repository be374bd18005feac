"""Laws against solvers: Dahl and Leuven with any exponent."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

F_S, F_C, V_S, SIGMA_0, SIGMA_1 = 8.999, 5.999, 5.5697e-4, 3.9162e5, 4424.8
H = 5e-4  # s


@pytest.mark.parametrize("i", [0.0, 0.5, 0.999999, 1.000001, 1.5, 2.0])
@pytest.mark.parametrize("v", [1e-9, 1e-5, 1e-3])
def test_dahl_with_any_exponent(follow, i, v):
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


TWO = {
    "kappa[1]": 0.612839, "kappa[2]": 0.0, "kappa[3]": 0.0, "kappa[4]": 0.387161, "W[1]": 3.0 / F_C,
}  # fmt: skip


def stretching(v: float, q: np.ndarray, n: float) -> tuple[float, float]:
    """Return dz/dt [m/s] and the force of two elements [N], by the published equation."""
    force = SIGMA_0 * float(np.dot([0.612839, 0.387161], q))
    g = F_C + (F_S - F_C) * np.exp(-abs(v) / V_S)
    return v * (1.0 - np.sign(force * v) * abs(force / g) ** n), force


@pytest.mark.parametrize(("n", "near"), [(0.5, 0.03), (1.0, 1e-9), (2.0, 2e-3), (3.0, 5e-3)])
def test_leuven_with_any_exponent(follow, n, near):
    """Start against the motion, let the first element slip, turn; steps of 2 um."""
    v = 4e-3 * np.array([1.0] * 10 + [-1.0] * 14)
    found = follow("leuven", H, v, n_h=n, **TWO, **{"q[1]": -5e-6, "q[4]": -5e-6})
    q, reach, expected = np.array([-5.0, -5.0]), 3.0 / (0.612839 * SIGMA_0) * 1e6, []

    for speed in v:

        def motion(_: float, q: np.ndarray, speed: float = speed) -> list[float]:
            rate, _ = stretching(speed, 1e-6 * np.clip(q, [-reach, -np.inf], [reach, np.inf]), n)
            slips = abs(q[0]) >= reach and q[0] * rate > 0.0
            return [0.0 if slips else 1e6 * rate, 1e6 * rate]

        tight = {"rtol": 1e-10, "atol": 1e-10, "max_step": H / 50}
        q = solve_ivp(motion, (0.0, H), q, "RK45", **tight).y[:, -1]
        q[0] = np.clip(q[0], -reach, reach)
        rate, force = stretching(speed, 1e-6 * q, n)
        expected.append(force + SIGMA_1 * rate)
    np.testing.assert_allclose(found["F_f"][1:], expected, atol=near)
