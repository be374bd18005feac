"""LuGre with a damping that fades with the velocity; test_bristle.py has the law of the paper."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

H = 5e-4  # s
F_S, F_C, V_S, SIGMA_0, SIGMA_1 = 8.999, 5.999, 5.5697e-4, 3.9162e5, 4424.8
M, B = 5.557, 6.6135  # kg, N s/m
V_D = 2e-3  # m/s


def test_the_damping_fades_with_the_velocity(follow):
    """sigma_1 exp(-(v / v_d)^2) takes the place of sigma_1, and z is as before."""
    v = 3e-3 * np.sin(np.arange(400) * 0.05)
    whole, none = (follow("lugre", H, v, sigma_1=s)["F_mean"] for s in (SIGMA_1, 0.0))
    faded = follow("lugre", H, v, v_d=V_D)["F_mean"]
    share = np.exp(-((v / V_D) ** 2))
    np.testing.assert_allclose(faded, none + share * (whole - none), atol=1e-12)
    assert abs(whole - faded).max() > 1.0


@pytest.mark.parametrize(("v_d", "passive"), [(0.0, False), (V_D, True)])
def test_a_fast_start_from_break_away_is_not_pushed(follow, v_d, passive):
    """From z = F_s / sigma_0 the force is F_s - sigma_1 v (F_s - F_c) / F_c: -35 N at 20 mm/s."""
    v = np.full(20, 0.02)
    force = follow("lugre", 1e-6, v, v_d=v_d, z=F_S / SIGMA_0)["F_mean"]
    assert (force.min() > 0.0) == passive


def test_a_pushed_mass_against_radau(push):
    u = np.repeat([5.0, 12.0, -3.0, -14.0], 40)
    found, y = push("lugre", H, u, v_d=V_D), np.zeros(3)  # um, mm/s, um
    for k in range(0, len(u), 40):

        def motion(_: float, y: np.ndarray, force: float = u[k]) -> list[float]:
            v, z = 1e-3 * y[1], 1e-6 * y[2]
            dz = v - SIGMA_0 * abs(v) / (F_C + (F_S - F_C) * np.exp(-abs(v) / V_S)) * z
            damping = SIGMA_1 * np.exp(-((v / V_D) ** 2))
            return [v * 1e6, (force - B * v - SIGMA_0 * z - damping * dz) / M * 1e3, dz * 1e6]

        y = solve_ivp(motion, (0.0, 40 * H), y, "Radau", rtol=1e-9, atol=1e-9).y[:, -1]
        assert 1e3 * found["v"][k + 40] == pytest.approx(y[1], abs=2e-3)
        assert 1e6 * found["x"][k + 40] == pytest.approx(y[0], abs=0.01)
    assert np.ptp(found["v"]) > 0.03
