"""The elasto-plastic law against a solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

H = 5e-4  # s
P = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4424.8}


def stretching(v: float, z: float, p: dict[str, float], z_ba: float) -> float:
    """Return dz/dt [m/s] from the published equations, in which alpha is a sine."""
    g = p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-abs(v) / p["v_s"])
    z_m, z_e = g / p["sigma_0"], z_ba * p["F_c"] / p["sigma_0"]
    if z * v <= 0.0 or abs(z) <= z_e:
        return v
    wave = 0.5 * np.sin(np.pi * (abs(z) - (z_m + z_e) / 2) / (z_m - z_e)) + 0.5
    return float(v - (wave if abs(z) < z_m else 1.0) * abs(v) * z / z_m)


@pytest.mark.parametrize("z_ba", [0.0, 0.05, 0.7, 0.95])
@pytest.mark.parametrize("v", [1e-6, 3e-4, -0.02, 1.0])
def test_a_constant_speed_against_a_solver(follow, z_ba, v):
    """From a deflection against the motion, over paths far below and far above break-away."""
    start, steps = -np.sign(v) * 10e-6, 12
    found = follow("elasto_plastic", H, np.full(steps, v), z_ba=z_ba, z=start)
    exact = solve_ivp(
        lambda _, y: [1e6 * stretching(v, 1e-6 * y[0], P, z_ba)],
        (0.0, steps * H),
        [1e6 * start],
        "LSODA",
        t_eval=np.arange(steps + 1) * H,
        rtol=1e-11,
        atol=1e-11,
        max_step=1e-6 / abs(v),
    )
    rates = [stretching(v, 1e-6 * z, P, z_ba) for z in exact.y[0]]
    force = P["sigma_0"] * 1e-6 * exact.y[0] + P["sigma_1"] * np.array(rates)
    np.testing.assert_allclose(found["F_f"][1:], force[1:], rtol=1e-8, atol=1e-8)
